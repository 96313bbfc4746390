// SPDX-License-Identifier: BSD-3-Clause
#include "plugins/mavlink_interface/truth_viewer.hpp"

#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <nlohmann/json.hpp>
#include <span>
#include <string>

namespace cas::sim {
namespace {

constexpr std::uint16_t kViewerPort = 19410;  // of PX4's SIH, on which jMAVSim listens
constexpr double kUsualHz = 50;

InetAddress parse_remote(const base::ConfigNode& node) {
  const auto remote = node.find("remote");
  return remote ? InetAddress::parse(*remote) : InetAddress::loopback(kViewerPort);
}

}  // namespace

TruthViewer::TruthViewer(const base::ConfigNode& node, mav::Source self)
    : self_(self),
      remote_(parse_remote(node)),
      rate_(node.get_in("rate_hz", kUsualHz, 0.1, kMostTruthHz)),
      socket_(socket(remote_.family(), SOCK_DGRAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0)) {
  if (socket_ < 0) node.fail(std::string("no socket: ") + std::strerror(errno));
}

TruthViewer::~TruthViewer() { close(socket_); }

void TruthViewer::show(const mavlink::common::HilStateQuaternion& truth) {
  const std::size_t size = mav::encode(truth, self_, sequence_++, packet_);
  const ssize_t sent = sendto(socket_, packet_.data(), size, MSG_DONTWAIT | MSG_NOSIGNAL,
                              remote_.data(), remote_.size());
  ++(sent == static_cast<ssize_t>(size) ? sent_ : not_taken_);
}

nlohmann::ordered_json TruthViewer::figures() const {
  return {{"remote", remote_.text()},
          {"rate_hz", rate_.rate_hz()},
          {"sent", sent_},
          {"not_taken", not_taken_}};
}

}  // namespace cas::sim
