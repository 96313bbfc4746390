// SPDX-License-Identifier: BSD-3-Clause
#include "plugins/mavlink_interface/tcp_server_port.hpp"

#include <netinet/tcp.h>
#include <poll.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <nlohmann/json.hpp>
#include <system_error>

#include "base/os/log.hpp"
#include "mavlink_gen/runtime/packet.hpp"

namespace cas::sim {
namespace {

/// No text begins with either of the two bytes, nor do HTTP, WebSocket and TLS.
bool may_begin_packet(std::uint8_t byte) { return byte == mav::kStartV1 || byte == mav::kStartV2; }

constexpr int kBacklog = 4;

bool is_readable(int socket) {
  pollfd entry{socket, POLLIN, 0};
  return ::poll(&entry, 1, 0) > 0;
}

void enable(int socket, int level, int name) {
  const int on = 1;
  setsockopt(socket, level, name, &on, sizeof on);  // each of them is an improvement only
}

bool would_block(int error) { return error == EAGAIN || error == EWOULDBLOCK || error == EINTR; }

}  // namespace

TcpServerPort::TcpServerPort(const InetAddress& local, base::Duration patience)
    : patience_(patience) {
  const auto fail = [this] {
    const int error = errno;
    if (listener_ >= 0) close(listener_);
    throw std::system_error(error, std::generic_category());
  };
  listener_ = socket(local.family(), SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
  if (listener_ < 0) fail();
  enable(listener_, SOL_SOCKET, SO_REUSEADDR);
  if (bind(listener_, local.data(), local.size()) != 0) fail();
  if (listen(listener_, kBacklog) != 0) fail();
}

TcpServerPort::~TcpServerPort() {
  if (client_ >= 0) close(client_);
  close(listener_);
}

void TcpServerPort::accept_client() {
  InetAddress source;
  socklen_t size = source.size();
  client_ = accept4(listener_, source.data(), &size, SOCK_NONBLOCK | SOCK_CLOEXEC);
  if (client_ < 0) return;
  source.set_size(size);
  enable(client_, IPPROTO_TCP, TCP_NODELAY);
  ++connections_;
  accepted_ = base::steady_now();
  base::log::info(endpoint() + ": a flight controller has connected from " + source.text());
}

void TcpServerPort::drop_client(const char* why) {
  close(client_);
  client_ = -1;
  tail_.clear();
  speaks_mavlink_ = false;
  base::log::info(endpoint() + ": the flight controller is gone (" + why +
                  "); waiting for the next");
}

void TcpServerPort::refuse_client() {
  close(client_);
  client_ = -1;
  tail_.clear();
  if (refused_clients_++ > 0) return;  // a page in a browser can open many
  base::log::warn(endpoint() +
                  ": a client begins with no MAVLink packet (a browser, perhaps) and was closed "
                  "unread; more of them are only counted (refused_clients)");
}

void TcpServerPort::yield_place() {
  if (speaks_mavlink_ || base::steady_now() - accepted_ < patience_) return;
  if (is_readable(listener_)) drop_client("it has said nothing, and another client waits");
}

bool TcpServerPort::flush_tail() {
  if (tail_.empty()) return true;
  const ssize_t sent = ::send(client_, tail_.data(), tail_.size(), MSG_DONTWAIT | MSG_NOSIGNAL);
  if (sent > 0) tail_.erase(tail_.begin(), tail_.begin() + sent);
  return tail_.empty();
}

bool TcpServerPort::send(std::span<const std::uint8_t> packet) {
  if (client_ < 0) {
    ++without_peer_;
    return false;
  }
  if (!flush_tail()) {
    ++queue_full_;
    return false;
  }
  const ssize_t sent = ::send(client_, packet.data(), packet.size(), MSG_DONTWAIT | MSG_NOSIGNAL);
  if (sent < 0) {
    if (would_block(errno)) {
      ++queue_full_;
    } else {
      drop_client(std::strerror(errno));
    }
    return false;
  }
  const auto rest = packet.subspan(static_cast<std::size_t>(sent));
  tail_.assign(rest.begin(), rest.end());
  ++sent_packets_;
  return true;
}

void TcpServerPort::poll(const OnBytes& on_bytes) {
  if (client_ < 0) accept_client();
  while (client_ >= 0) {
    const ssize_t size = recv(client_, buffer_.data(), buffer_.size(), MSG_DONTWAIT);
    if (size < 0 && would_block(errno)) return yield_place();
    if (size < 0) return drop_client(std::strerror(errno));
    if (size == 0) return drop_client("connection closed");
    if (!speaks_mavlink_ && !may_begin_packet(buffer_.front())) return refuse_client();
    speaks_mavlink_ = true;
    on_bytes({buffer_.data(), static_cast<std::size_t>(size)}, base::steady_now());
    if (static_cast<std::size_t>(size) < buffer_.size()) return;
  }
}

bool TcpServerPort::wait(base::Duration timeout) {
  return wait_readable(client_ >= 0 ? client_ : listener_, -1, timeout);
}

std::string TcpServerPort::endpoint() const { return "tcp " + bound_address(listener_); }

void TcpServerPort::add_figures(nlohmann::ordered_json& figures) const {
  figures["connections"] = connections_;
  figures["refused_clients"] = refused_clients_;
  figures["connected"] = connected();
  figures["sent_packets"] = sent_packets_;
  figures["queue_full"] = queue_full_;
  figures["without_peer"] = without_peer_;
}

}  // namespace cas::sim
