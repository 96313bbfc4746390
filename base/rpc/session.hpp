// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <boost/asio/generic/stream_protocol.hpp>
#include <boost/asio/steady_timer.hpp>
#include <chrono>
#include <cstddef>
#include <deque>
#include <functional>
#include <memory>
#include <string>

#include "base/os/lack_of_memory.hpp"
#include "base/rpc/client_places.hpp"
#include "base/rpc/dispatcher.hpp"
#include "base/rpc/line_rate.hpp"
#include "base/rpc/serve_budget.hpp"
#include "base/rpc/server.hpp"

namespace cas::base::rpc {

using StreamSocket = boost::asio::generic::stream_protocol::socket;

/// One client of a Server. Everything runs on the thread of `io`; no lock.
///
///   do_read --> on_line --> dispatcher --> deliver() --> do_write <-+
///      ^-----------+                                        +-------+
///
/// Ends by close() at once (error, a client that never reads), or by finish(): no further line is
/// read, answers under way are still sent, then the connection is drained so that they are not
/// lost. refuse() and a line that is not JSON-RPC finish() it.
class Session final : public Peer, public std::enable_shared_from_this<Session> {
 public:
  using Line = std::shared_ptr<const std::string>;

  Session(StreamSocket socket, std::shared_ptr<Dispatcher> dispatcher, const ServerLimits& limits,
          std::shared_ptr<ServeBudget> budget,
          std::function<void(const std::shared_ptr<Session>&)> on_closed);

  /// Reads lines. Refuses a client that makes no request in time, or has not authorised in time
  /// where a token is required.
  void start();
  /// Tells the client why it is not served any longer, and ends.
  void refuse(Refusal why, const std::string& message, int code = kInternalError);
  const ClientOrigin& origin() const { return origin_; }
  /// Whether the first request has come, and the client is authorised.
  bool has_asked() const { return asked_; }
  /// Whether a line has come.
  bool has_spoken() const { return spoke_; }
  void deliver(std::string line) override;
  std::size_t room() const override;
  void deliver_shared(Line line);
  void close();

 private:
  void on_call_ended() override;
  void on_refused() override { finish(); }

  /// For Asio: `handler` with this session. Lack of memory in it closes the session.
  template <class Handler>
  auto guarded(Handler handler) {
    return [self = shared_from_this(), handler](const auto&... arguments) {
      const auto handle = [&] { handler(*self, arguments...); };
      if (!outlive_lack_of_memory(self->name, handle)) self->close();
    };
  }
  void do_read();
  void read_at_rate();
  void await_first_request();
  void on_line(std::size_t size);
  void on_read_end(bool line_too_long);
  void do_write();
  void on_written(std::size_t lines);
  void finish();
  void end_when_idle();
  void close_after(std::chrono::seconds time);
  void do_drain();

  StreamSocket socket_;
  ClientOrigin origin_;
  boost::asio::steady_timer deadline_;      // of the first request, then of the end
  std::shared_ptr<Dispatcher> dispatcher_;  // null once closed
  ServerLimits limits_;
  boost::asio::steady_timer pause_;  // until the next line may be read
  LineRate rate_;
  std::shared_ptr<ServeBudget> budget_;  // of all clients
  Duration cost_{};                      // of the newest line, processor time
  std::function<void(const std::shared_ptr<Session>&)> on_closed_;
  std::string rx_;
  std::array<char, 4096> drained_{};
  std::deque<Line> tx_;
  std::size_t tx_bytes_ = 0;
  bool asked_ = false;
  bool spoke_ = false;
  bool writing_ = false;
  bool finishing_ = false;
  bool draining_ = false;
  bool flushing_ = false;
  bool closed_ = false;
};

}  // namespace cas::base::rpc
