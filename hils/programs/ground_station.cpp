// SPDX-License-Identifier: BSD-3-Clause
#include "hils/programs/ground_station.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <utility>

#include "mavlink/common/param_request_list.hpp"
#include "mavlink/common/table.hpp"
#include "mavlink_gen/services/station_heartbeat.hpp"

namespace cas::hils {

namespace {

namespace mv = mavlink::common;

constexpr base::Duration kHeartbeatPeriod = std::chrono::seconds(1);
constexpr base::Duration kSticksPeriod = std::chrono::milliseconds(40);  ///< as QGroundControl

mv::ManualControl to_vehicle(std::uint8_t system, const Sticks& sticks) {
  mv::ManualControl message = manual_control(sticks);
  message.target = system;
  return message;
}

}  // namespace

mv::ManualControl manual_control(const Sticks& sticks) {
  constexpr double kFullStick = 1000;
  const auto to_stick = [](double share) {
    return static_cast<std::int16_t>(std::lround(share * kFullStick));
  };
  mv::ManualControl message;
  message.x = to_stick(sticks.pitch);
  message.y = to_stick(sticks.roll);
  message.z = to_stick((1 + sticks.climb) / 2);  // the middle keeps the height
  message.r = to_stick(sticks.yaw);
  return message;
}

GroundStation::GroundStation(const std::vector<std::uint8_t>& systems, base::Duration list_period,
                             Send send)
    : list_period_(list_period),
      send_(std::move(send)),
      encode_(kGroundStation),
      parser_(mv::table()) {
  for (const std::uint8_t system : systems) vehicles_.push_back({.system = system});
}

void GroundStation::on_bytes(std::span<const std::uint8_t> bytes) {
  parser_.feed(bytes, [this](const mav::PacketView& packet) { on_packet(packet); });
}

void GroundStation::on_packet(const mav::PacketView& packet) {
  if (packet.message_id != mv::Heartbeat::kId) return;
  const auto sender = std::ranges::find(vehicles_, packet.source.system, &Vehicle::system);
  if (sender != vehicles_.end()) sender->heard = true;
}

void GroundStation::tick(base::RunTime now) {
  if (silent_) {
    last_tick_ = now;
    return;
  }
  send_flood(std::exchange(last_tick_, now), now);
  if (now >= next_heartbeat_) {
    send_(encode_(mav::services::station_heartbeat(mv::MavType::kGcs)));
    next_heartbeat_ = now + kHeartbeatPeriod;
  }
  for (Vehicle& vehicle : vehicles_) {
    if (vehicle.heard) attend(vehicle, now);
  }
}

void GroundStation::hold(std::uint8_t system, const Sticks& sticks) {
  const auto vehicle = std::ranges::find(vehicles_, system, &Vehicle::system);
  if (vehicle != vehicles_.end()) vehicle->sticks = sticks;
}

void GroundStation::attend(Vehicle& vehicle, base::RunTime now) {
  if (!sticks_lost_ && now >= vehicle.next_sticks) {
    send_(encode_(to_vehicle(vehicle.system, vehicle.sticks)));
    vehicle.next_sticks = now + kSticksPeriod;
  }
  if (vehicle.next_list && now < *vehicle.next_list) return;
  mv::ParamRequestList request;
  request.target_system = vehicle.system;
  request.target_component = 1;
  send_(encode_(request));
  vehicle.next_list = now + list_period_;
}

/// On a grid, so that short ticks lose nothing; after a stall no more than a moment's worth.
void GroundStation::send_flood(base::RunTime last, base::RunTime now) {
  constexpr base::Duration kMostAtOnce = std::chrono::milliseconds(100);
  const base::RunTime begin = std::max(last, now - kMostAtOnce);
  const std::int64_t end = flood_.index_at(now.time_since_epoch());
  for (std::int64_t i = flood_.index_at(begin.time_since_epoch()); i < end; ++i) {
    const auto turn = static_cast<std::size_t>(i) % vehicles_.size();
    send_(encode_(to_vehicle(vehicles_[turn].system, vehicles_[turn].sticks)));
  }
}

GroundStationThread::GroundStationThread(const std::vector<std::uint8_t>& systems)
    : socket_("cannot open a UDP port for the ground station"),
      station_(systems, kParameterListPeriod,
               [this](std::span<const std::uint8_t> bytes) { socket_.send(bytes); }),
      thread_(socket_.fd(), GroundStation::kTickPeriod, [this] { look(); }) {}

void GroundStationThread::look() {
  base::MutexLock lock(mutex_);
  while (true) {
    const std::span<const std::uint8_t> bytes = socket_.read();
    if (bytes.empty()) break;
    station_.on_bytes(bytes);
  }
  station_.tick(base::steady_now());
}

}  // namespace cas::hils
