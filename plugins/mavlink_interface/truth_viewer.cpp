// SPDX-License-Identifier: BSD-3-Clause
#include "plugins/mavlink_interface/truth_viewer.hpp"

#include <nlohmann/json.hpp>
#include <span>

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
      sender_(node, parse_remote(node)),
      rate_(node.get_in("rate_hz", kUsualHz, 0.1, kMostTruthHz)) {}

void TruthViewer::show(const mavlink::common::HilStateQuaternion& truth) {
  const std::size_t size = mav::encode(truth, self_, sequence_++, packet_);
  sender_.send(std::span(packet_).first(size));
}

nlohmann::ordered_json TruthViewer::figures() const {
  nlohmann::ordered_json figures = sender_.figures();
  figures["rate_hz"] = rate_.rate_hz();
  return figures;
}

}  // namespace cas::sim
