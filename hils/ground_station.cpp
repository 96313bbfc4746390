// SPDX-License-Identifier: BSD-3-Clause
#include "hils/ground_station.hpp"

#include <algorithm>
#include <chrono>
#include <utility>

#include "mavlink/common/heartbeat.hpp"
#include "mavlink/common/manual_control.hpp"
#include "mavlink/common/param_request_list.hpp"
#include "mavlink/common/param_value.hpp"
#include "mavlink/common/table.hpp"

namespace cas::hils {

namespace {

namespace mv = mavlink::common;

constexpr mav::Source kGroundStation{255, 190};  ///< the ids that ground stations use
constexpr base::Duration kHeartbeatPeriod = std::chrono::seconds(1);
constexpr base::Duration kSticksPeriod = std::chrono::milliseconds(40);  ///< as QGroundControl

mv::Heartbeat heartbeat() {
  mv::Heartbeat message;
  message.type = mv::MavType::kGcs;
  message.autopilot = mv::MavAutopilot::kInvalid;
  message.system_status = mv::MavState::kActive;
  message.mavlink_version = 3;
  return message;
}

/// On-screen sticks that nobody touches.
mv::ManualControl centred_sticks(std::uint8_t vehicle_system) {
  mv::ManualControl message;
  message.target = vehicle_system;
  message.z = 500;
  return message;
}

}  // namespace

GroundStation::GroundStation(std::uint8_t vehicle_system, base::Duration list_period, Send send)
    : vehicle_system_(vehicle_system),
      list_period_(list_period),
      send_(std::move(send)),
      encode_(kGroundStation),
      parser_(mv::table()) {}

void GroundStation::on_bytes(std::span<const std::uint8_t> bytes) {
  parser_.feed(bytes, [this](const mav::PacketView& packet) { on_packet(packet); });
}

void GroundStation::on_packet(const mav::PacketView& packet) {
  if (packet.source.system != vehicle_system_) return;
  ++received_;
  if (packet.message_id == mv::Heartbeat::kId) vehicle_heard_ = true;
  if (const auto value = mav::decode<mv::ParamValue>(packet)) {
    parameters_.insert(value->param_index);
  }
}

void GroundStation::tick(base::RunTime now) {
  const double since_s = std::min(base::to_seconds(now - last_tick_), 0.1);
  last_tick_ = now;
  const auto extra = static_cast<int>(flood_hz_ * since_s);
  for (int i = 0; i < extra; ++i) send_(encode_(centred_sticks(vehicle_system_)));
  if (now >= next_heartbeat_) {
    send_(encode_(heartbeat()));
    next_heartbeat_ = now + kHeartbeatPeriod;
  }
  if (vehicle_heard_ && now >= next_sticks_) {
    send_(encode_(centred_sticks(vehicle_system_)));
    next_sticks_ = now + kSticksPeriod;
  }
  if (!vehicle_heard_ || (next_list_ && now < *next_list_)) return;
  mv::ParamRequestList request;
  request.target_system = vehicle_system_;
  request.target_component = 1;
  send_(encode_(request));
  next_list_ = now + list_period_;
}

}  // namespace cas::hils
