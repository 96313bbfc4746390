// SPDX-License-Identifier: BSD-3-Clause
#include "plugins/ardupilot_json/json_link.hpp"

#include <unistd.h>

#include <cerrno>
#include <system_error>

namespace cas::sim {

JsonLink::JsonLink(const InetAddress& local) {
  socket_ = socket(local.family(), SOCK_DGRAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
  if (socket_ >= 0 && bind(socket_, local.data(), local.size()) == 0) return;
  const int error = errno;
  if (socket_ >= 0) close(socket_);
  throw std::system_error(error, std::generic_category());
}

JsonLink::~JsonLink() { close(socket_); }

std::optional<std::span<const std::uint8_t>> JsonLink::receive() {
  InetAddress source;
  socklen_t size = source.size();
  const ssize_t bytes =
      recvfrom(socket_, buffer_.data(), buffer_.size(), MSG_DONTWAIT, source.data(), &size);
  if (bytes < 0) return std::nullopt;
  source.set_size(size);
  peer_ = source;
  return std::span<const std::uint8_t>(buffer_).first(static_cast<std::size_t>(bytes));
}

bool JsonLink::send(std::string_view text) {
  if (!peer_) return false;
  return sendto(socket_, text.data(), text.size(), MSG_DONTWAIT | MSG_NOSIGNAL, peer_->data(),
                peer_->size()) == static_cast<ssize_t>(text.size());
}

}  // namespace cas::sim
