// SPDX-License-Identifier: BSD-3-Clause
#include "plugins/common/companion.hpp"

#include <array>
#include <nlohmann/json.hpp>
#include <span>

#include "mavlink/common/table.hpp"
#include "mavlink_gen/services/station_heartbeat.hpp"
#include "plugins/common/plugin_messages.hpp"

namespace cas::sim {
namespace {

namespace mv = mavlink::common;

constexpr double kHeartbeat_hz = 1;
constexpr int kMostDatagrams = 64;  // in a step: a sender that never pauses is not waited for

}  // namespace

Companion::Companion(const base::ConfigNode& remote, mav::Source self)
    : datagrams_(remote, InetAddress::parse(remote)),
      self_(self),
      parser_(mv::table()),
      heartbeat_(kHeartbeat_hz) {}

void Companion::send(const mav::MessageInfo& info, const MavlinkMessage& message) {
  std::array<std::uint8_t, mav::kMaxPacketBytes> packet;
  const std::size_t size = encode_message(info, message, self_, sequence_++, packet);
  datagrams_.send(std::span(packet).first(size));
}

template <class Message>
void Companion::send(const Message& message) {
  std::array<std::uint8_t, mav::kMaxPacketBytes> packet;
  datagrams_.send(std::span(packet).first(mav::encode(message, self_, sequence_++, packet)));
}

void Companion::serve_terrain(base::SimTime now, const TerrainSource::Elevation& elevation_m) {
  serves_terrain_ = true;
  if (heartbeat_.due(now)) {
    send(mav::services::station_heartbeat(mv::MavType::kOnboardController));
  }
  read();
  if (const auto grid = terrain_.next(now, elevation_m)) {
    send(*grid);
    ++grids_;
  }
}

void Companion::read() {
  for (int i = 0; i < kMostDatagrams; ++i) {
    std::array<std::uint8_t, 2048> buffer;
    const auto bytes = datagrams_.receive(buffer);
    if (!bytes) return;
    parser_.feed(*bytes, [this](const mav::PacketView& packet) {
      const auto request = mav::decode<mv::TerrainRequest>(packet);
      if (!request) return;
      terrain_.take(*request);
      ++requests_;
    });
  }
}

void Companion::reset() {
  heartbeat_ = base::RateGate(kHeartbeat_hz);
  terrain_ = {};
}

nlohmann::ordered_json Companion::figures() const {
  nlohmann::ordered_json figures = datagrams_.figures();
  if (serves_terrain_) {
    figures["terrain_requests"] = requests_;
    figures["grids"] = grids_;
  }
  return figures;
}

}  // namespace cas::sim
