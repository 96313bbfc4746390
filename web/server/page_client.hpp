// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "base/rpc/dispatcher.hpp"
#include "base/rpc/line_rate.hpp"
#include "base/time/clock.hpp"
#include "web/server/snapshot_flow.hpp"

namespace cas::web {

class PageHub;
class Upstream;

/// Secret that a page must prove to know first.
struct PageAccess {
  std::string token;
  bool read_only = false;
};

/// One watched message: the request, and the samples that have not been sent.
struct ValueWatch {
  std::string link;
  std::string message;
  int system = 0;
  int component = 0;
  std::vector<std::string> fields{};
  base::Duration period{};
  base::RunTime next{};                ///< time of the next request
  std::vector<std::string> samples{};  ///< as JSON, the oldest first
  std::uint64_t seen = 0;              ///< count of the packet sampled last
};

/// One page behind its socket: its calls, watches and rights. No socket in it.
class PageClient final : public base::rpc::Peer, public std::enable_shared_from_this<PageClient> {
 public:
  /// Bytes of one answer, and of the answers of unfinished batches.
  static constexpr std::size_t kMaxHeld = 16U << 20;

  using Text = std::shared_ptr<const std::string>;
  struct Socket {
    std::function<void(Text)> send;
    std::function<void(int code, const std::string& reason)> close;
    std::function<void()> refuse_token;  ///< closes with 4403, after a while
  };

  /// @param host  where the page was opened, "127.0.0.1:5791": proofs hold for this place alone
  PageClient(PageHub& hub, const PageAccess& access, const std::string& host, Socket socket);
  ~PageClient() override;

  /// One text frame.
  void on_text(std::string_view text);
  /// Whether it has said hello.
  bool greeted() const { return authorised; }
  std::uint64_t number() const { return number_; }

  void deliver(std::string line) override;
  std::size_t room() const override { return kMaxHeld - std::min(kMaxHeld, held_bytes); }
  void on_refused() override;
  /// Sends a frame that several pages get.
  void send(const Text& text) { socket_.send(text); }

  /// Whether to send a present snapshot of the topic to this page.
  bool wants(const std::string& topic, base::RunTime now) const;
  /// Whether the page waits for one, now or soon.
  bool waits(const std::string& topic) const;
  void send_snapshot(const std::string& topic, std::uint64_t seq, const Text& text,
                     base::RunTime now);
  /// By key.
  std::map<std::string, ValueWatch>& values() { return values_; }
  std::size_t watched_fields() const;

 private:
  using Json = base::rpc::Json;
  using Reply = base::rpc::Reply;

  void answer(const Json& request, const char* key, Json value);
  void hello(const Json& request);
  void add_methods();
  void add_own_methods();
  void add_refused(const char* name);
  void add_passed(const char* name, Upstream* to, bool is_limited);
  bool may_change();
  void pass(const std::string& method, Upstream& to, const Json& params, const Reply& reply);
  void watch(const Json& params, const Reply& reply);
  void on_ack(const Json& params, const Reply& reply);
  void watch_message(const Json& params, const Reply& reply);
  void unwatch_message(const Json& params, const Reply& reply);
  void move_sticks(const Json& params, const Reply& reply);

  PageHub& hub_;
  PageAccess access_;
  Socket socket_;
  std::uint64_t number_;
  base::rpc::Dispatcher dispatcher_;
  std::vector<std::string> methods_;
  base::rpc::LineRate changes_;
  std::map<std::string, SnapshotFlow, std::less<>> flows_;  // by topic
  std::map<std::string, ValueWatch> values_;
  bool refused_ = false;  // its proof was wrong: one try a connection
};

}  // namespace cas::web
