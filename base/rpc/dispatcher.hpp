// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "base/export.hpp"
#include "base/rpc/description.hpp"
#include "base/rpc/message.hpp"
#include "base/rpc/token_proof.hpp"

namespace cas::base::rpc {

struct AnswerBatch;

/// The client that a line came from, as the dispatcher sees it.
class CAS_BASE_EXPORT Peer {
 public:
  virtual ~Peer() = default;
  /// Sends one line (without its newline).
  virtual void deliver(std::string line) = 0;
  /// Bytes that may still wait for the client. A longer answer becomes an error answer.
  virtual std::size_t room() const { return SIZE_MAX; }
  /// A call has ended; `calls` is already lower by one.
  virtual void on_call_ended() {}
  /// `refusal` was set by a line that has been answered: no further line is read.
  virtual void on_refused() {}

  /// For an audit: "127.0.0.1:40412", "unix:uid 1000", once introduced "unix:uid 1000 (hils-4711)".
  std::string name;
  std::string program;           ///< name that it gave itself; empty: none
  std::set<std::string> topics;  ///< subscribed
  ProofContext proof;            ///< `endpoint`, and the nonces once they are exchanged
  bool authorised = true;
  Refusal refusal = Refusal::kNone;
  std::size_t calls = 0;  ///< under way
  /// Batches with calls under way, which end with the client, and the bytes of their answers.
  std::vector<std::shared_ptr<AnswerBatch>> batches;
  std::size_t held_bytes = 0;
  double weight = 0;  ///< greatest of a line's calls; the caller of handle() resets it
};

/// JSON-RPC 2.0 without a socket: takes a line, calls methods, delivers answers. Not for several
/// threads.
class CAS_BASE_EXPORT Dispatcher {
 public:
  Dispatcher();

  /// @param weight  share of a call's processor time that its client pays for (1: all of it)
  void add_method(const std::string& name, Method method, double weight = 1);
  void add_topic(const std::string& topic);
  /// Description of the methods for `rpc.discover`, beside their names.
  void describe(Description description);
  /// Called before each line with requests is handled.
  void before_calls(std::function<void()> callback) { before_calls_ = std::move(callback); }
  /// Peers that are not authorised must first call `authorise`: {"token": ...}, or {"nonce": ...}
  /// and then {"proof": ...} (token_proof()), so that the token itself is not sent.
  void set_token(std::string token) { token_ = std::move(token); }
  bool has_token() const { return token_.has_value(); }

  /// Calls a method without a peer: none of those that are answered for a peer's session.
  void call(const std::string& method, const Json& params, const Reply& reply) const;

  /// Handles one line; the answer may be delivered later. A peer that is gone by then misses it.
  /// A line that is no JSON, or holds something else than requests, is answered and refuses the
  /// peer. A blank line is skipped.
  /// @return whether the line held requests
  bool handle(std::string_view line, const std::shared_ptr<Peer>& peer);

  /// One notification as a line.
  static std::string notification(const std::string& topic, const Json& params);
  /// An error that answers no particular call.
  static std::string error_line(int code, const std::string& message);

 private:
  /// Also takes a result that is text already.
  struct TextReply : Reply {
    std::function<void(const std::string& json)> text;
  };
  using SessionMethod = void (Dispatcher::*)(const Json& params, Peer& peer,
                                             const TextReply& reply);
  class Call;

  void handle_text(std::string_view line, const std::shared_ptr<Peer>& peer);
  void handle_batch(const Json& requests, const std::shared_ptr<Peer>& peer);
  void handle_request(const Json& request, const std::shared_ptr<Peer>& peer,
                      const std::shared_ptr<AnswerBatch>& batch);
  void invoke(const std::string& method, const Json& params, const std::shared_ptr<Peer>& peer,
              const TextReply& reply);
  void call(const std::string& method, const Json& params, Peer& peer, const TextReply& reply);
  void subscribe(const Json& params, Peer& peer, const TextReply& reply);
  void unsubscribe(const Json& params, Peer& peer, const TextReply& reply);
  void introduce(const Json& params, Peer& peer, const TextReply& reply);
  void authorise(const Json& params, Peer& peer, const TextReply& reply);
  void exchange_nonces(const std::string& nonce, Peer& peer, const TextReply& reply);
  bool proves_token(const std::string& proof, const Peer& peer) const;
  void methods(const Json& params, Peer& peer, const TextReply& reply);
  void discover(const Json& params, Peer& peer, const TextReply& reply);
  std::vector<std::string> method_names() const;

  // Shared with a running call, which may end the server that holds it.
  struct Weighed {
    std::shared_ptr<const Method> method;
    double weight = 1;
  };
  std::map<std::string, Weighed> methods_;
  std::map<std::string, SessionMethod> session_methods_;
  std::set<std::string> topics_;
  std::function<void()> before_calls_;
  Description description_;
  std::string document_;  ///< answer of `rpc.discover`; empty: it is to be made
  std::optional<std::string> token_;
};

}  // namespace cas::base::rpc
