// SPDX-License-Identifier: BSD-3-Clause
#include "plugins/common/datagram_link.hpp"

#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <nlohmann/json.hpp>
#include <string>

namespace cas::sim {

DatagramLink::DatagramLink(const base::ConfigNode& node, const InetAddress& remote)
    : remote_(remote),
      socket_(socket(remote_.family(), SOCK_DGRAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0)) {
  if (socket_ < 0) node.fail(std::string("no socket: ") + std::strerror(errno));
}

DatagramLink::~DatagramLink() { close(socket_); }

void DatagramLink::send(std::span<const std::uint8_t> packet) {
  const ssize_t sent = sendto(socket_, packet.data(), packet.size(), MSG_DONTWAIT | MSG_NOSIGNAL,
                              remote_.data(), remote_.size());
  ++(sent == static_cast<ssize_t>(packet.size()) ? sent_ : not_taken_);
}

std::optional<std::span<const std::uint8_t>> DatagramLink::receive(std::span<std::uint8_t> buffer) {
  while (true) {
    InetAddress source;
    socklen_t size = source.size();
    const ssize_t bytes =
        recvfrom(socket_, buffer.data(), buffer.size(), MSG_DONTWAIT, source.data(), &size);
    if (bytes < 0) return std::nullopt;
    source.set_size(size);
    if (source == remote_) return buffer.first(static_cast<std::size_t>(bytes));
  }
}

nlohmann::ordered_json DatagramLink::figures() const {
  return {{"remote", remote_.text()}, {"sent", sent_}, {"not_taken", not_taken_}};
}

}  // namespace cas::sim
