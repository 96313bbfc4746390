// SPDX-License-Identifier: BSD-3-Clause
#include "plugins/common/datagram_sender.hpp"

#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <nlohmann/json.hpp>
#include <string>

namespace cas::sim {

DatagramSender::DatagramSender(const base::ConfigNode& node, const InetAddress& remote)
    : remote_(remote),
      socket_(socket(remote_.family(), SOCK_DGRAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0)) {
  if (socket_ < 0) node.fail(std::string("no socket: ") + std::strerror(errno));
}

DatagramSender::~DatagramSender() { close(socket_); }

void DatagramSender::send(std::span<const std::uint8_t> packet) {
  const ssize_t sent = sendto(socket_, packet.data(), packet.size(), MSG_DONTWAIT | MSG_NOSIGNAL,
                              remote_.data(), remote_.size());
  ++(sent == static_cast<ssize_t>(packet.size()) ? sent_ : not_taken_);
}

nlohmann::ordered_json DatagramSender::figures() const {
  return {{"remote", remote_.text()}, {"sent", sent_}, {"not_taken", not_taken_}};
}

}  // namespace cas::sim
