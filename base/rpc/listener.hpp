// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <boost/asio/generic/stream_protocol.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/posix/stream_descriptor.hpp>
#include <boost/asio/steady_timer.hpp>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>

#include "base/os/descriptor.hpp"

namespace cas::base::rpc {

/// A listening descriptor, bound and closed on exec.
struct ListeningSocket {
  Descriptor fd;
  bool loopback = false;       ///< no other host can reach it
  std::uint16_t port = 0;      ///< TCP
  std::filesystem::path path;  ///< Unix; removed when the listener closes
};

/// @throws ConfigError
ListeningSocket open_tcp(const std::string& address, std::uint16_t port);
/// Mode 0600; a socket file that nobody listens on is replaced. @throws ConfigError
ListeningSocket open_unix(const std::filesystem::path& path);

/// Accepts clients with SOCK_CLOEXEC, which Asio's own acceptor leaves out.
class Listener final : public std::enable_shared_from_this<Listener> {
 public:
  using StreamSocket = boost::asio::generic::stream_protocol::socket;
  using OnClient = std::function<void(StreamSocket)>;

  /// Takes over the descriptor.
  Listener(boost::asio::io_context& io, ListeningSocket socket, OnClient on_client);

  void start() { do_wait(); }
  void close();

 private:
  void do_wait();
  void accept_waiting();
  void retry_later();

  boost::asio::io_context& io_;
  boost::asio::posix::stream_descriptor descriptor_;
  boost::asio::steady_timer retry_;
  std::filesystem::path path_;
  OnClient on_client_;
  bool starved_ = false;  // said so once
};

}  // namespace cas::base::rpc
