// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>

#include "base/export.hpp"
#include "base/rpc/description.hpp"
#include "base/rpc/message.hpp"
#include "base/time/clock.hpp"

namespace boost::asio {
class io_context;
}

namespace cas::base::rpc {

/// How long a client may stay without a request.
inline constexpr Duration kFirstRequestTime = std::chrono::seconds(10);

/// What the clients of a Server may take of its places, memory and processor time.
struct ServerLimits {
  std::size_t max_line_bytes = 64 * 1024;
  /// The clients of one address (all of loopback is one, an IPv6 network of 64 bits too) or of one
  /// user on Unix sockets take at most half of these places. On a Unix socket one place is kept for
  /// the server's own user and root, who displace silent clients when all are taken.
  std::size_t max_clients = 64;
  std::size_t max_queued_replies = 256;  ///< a client that never reads is closed
  std::size_t max_queued_bytes = 4 * 1024 * 1024;
  /// Lines of one client in a second, and as many at once; faster ones wait in its socket.
  double max_lines_s = 1000;
  /// Share of one processor that the requests of all clients together may use; 1: all of it.
  /// Requests above it are read later, from each client in turn, and new clients wait up to a
  /// second.
  double max_cpu_share = 1;
  /// Connections that are accepted in a second, and as many at once; the next ones wait. 0: any.
  double max_accepts_s = 0;
  /// A client must make its first request within this time, and where a token is asked for,
  /// `authorise`. From then on it may be silent as long as it likes.
  Duration first_request_time = kFirstRequestTime;
};

/// JSON-RPC 2.0 lines over TCP and Unix sockets; batches and notifications included. Everything
/// runs on the thread that runs `io`.
class CAS_BASE_EXPORT Server {
 public:
  explicit Server(boost::asio::io_context& io, ServerLimits limits = {});
  ~Server();
  Server(const Server&) = delete;
  Server& operator=(const Server&) = delete;

  /// @param weight  factor on its time for ServerLimits::max_cpu_share: less than 1 for calls that
  /// must not wait for those of others
  void add_method(const std::string& name, Method method, double weight = 1);
  /// Description of the methods for `rpc.discover`, beside their names.
  void describe(Description description);
  /// Calls a method from this process itself; `reply` is used now or later.
  void call(const std::string& name, const Json& params, const Reply& reply);
  /// Called before the requests of a line are served, to bring their data up to date.
  void before_calls(std::function<void()> callback);
  /// Sends {"method": name, "params": params} to each client that subscribed to `topic`.
  void publish(const std::string& topic, const Json& params);
  /// Whether a topic has subscribers; without them its message need not be built.
  bool has_subscribers(const std::string& topic) const;
  /// Methods `subscribe` {"topic": ...} and `unsubscribe` are answered by the server for these
  /// topics.
  void add_topic(const std::string& topic);

  /// TCP clients must first call `authorise` with the first line of this file, or a proof that they
  /// know it; its owner alone may read it. Unix sockets are guarded by their mode.
  /// @param loopback_exempt  clients of this machine need none @throws ConfigError
  void require_token(const std::filesystem::path& file, bool loopback_exempt = false);

  /// Starts to listen; port 0 takes a free one. An address that other hosts can reach needs a
  /// token. @return the bound port @throws AddressInUse, ConfigError
  std::uint16_t listen_tcp(const std::string& address, std::uint16_t port);
  /// Mode 0600, or 0660 for the members of a group where one is named; a stale socket file of this
  /// user is replaced, anything else in its place refused. @throws ConfigError
  void listen_unix(const std::filesystem::path& path, const std::string& group = {});
  /// Waits for clients anew, after a handler of the context has lacked memory.
  void start();
  /// Ends all connections and listening sockets; calls under way are not answered.
  void close();
  /// Clients being served.
  std::size_t clients() const;
  /// Connections that have been refused for this reason; counted when they are closed.
  std::uint64_t refused(Refusal why) const;

 private:
  struct Impl;
  std::shared_ptr<Impl> impl_;
};

}  // namespace cas::base::rpc
