// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <sys/types.h>

#include <boost/asio/generic/stream_protocol.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/posix/stream_descriptor.hpp>
#include <boost/asio/steady_timer.hpp>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "base/os/descriptor.hpp"
#include "base/rpc/line_rate.hpp"

namespace cas::base::rpc {

/// Tells the file of our Unix socket from one that took its place: close() must not unlink that.
struct SocketFile {
  dev_t device = 0;
  ino_t inode = 0;
};

/// A listening descriptor, bound and closed on exec.
struct ListeningSocket {
  Descriptor fd;
  bool loopback = false;       ///< no other host can reach it
  std::uint16_t port = 0;      ///< TCP
  std::filesystem::path path;  ///< Unix; removed when the listener closes, unless it is another's
  SocketFile file;             ///< Unix
};

/// @throws ConfigError
ListeningSocket open_tcp(const std::string& address, std::uint16_t port);
/// Replaces a socket file of this user that has no listener; anything else in its place is refused.
/// @param group  group whose members may connect as well (0660); empty: none (0600)
/// @throws ConfigError
ListeningSocket open_unix(const std::filesystem::path& path, const std::string& group = {});

/// Removes the socket files of earlier casds in their runtime folder: those of this user, with a
/// casd name and without a listener.
void remove_stale_sockets(const std::filesystem::path& folder);

/// Accepts clients with SOCK_CLOEXEC, which Asio's own acceptor leaves out. A client that has left
/// again without a byte costs nobody behind it any time.
class Listener final : public std::enable_shared_from_this<Listener> {
 public:
  using StreamSocket = boost::asio::generic::stream_protocol::socket;
  using OnClient = std::function<void(StreamSocket)>;

  /// Takes over the descriptor.
  /// @param max_accepts_s  rate, and burst, at which clients are accepted; 0: no limit
  /// @param patience  asked before each accept how long to delay it; empty: never
  Listener(boost::asio::io_context& io, ListeningSocket socket, OnClient on_client,
           double max_accepts_s = 0, std::function<Duration()> patience = {});

  /// Waits for clients; also anew, after a handler has lacked memory.
  void start();
  void close();

 private:
  void do_wait();
  void accept_waiting();
  void retry_later();
  void accept_after(Duration wait);

  boost::asio::io_context& io_;
  boost::asio::posix::stream_descriptor descriptor_;
  boost::asio::steady_timer retry_;
  std::filesystem::path path_;
  SocketFile file_;
  OnClient on_client_;
  std::optional<LineRate> rate_;
  std::function<Duration()> patience_;
  bool waited_ = false;   // the next clients have
  bool starved_ = false;  // said so once
};

}  // namespace cas::base::rpc
