// SPDX-License-Identifier: BSD-3-Clause
#include "hils/firmware/companion_station.hpp"

#include <algorithm>
#include <utility>
#include <variant>

#include "base/earth/deg_e7.hpp"
#include "hils/programs/ground_station.hpp"
#include "mavlink/common/attitude.hpp"
#include "mavlink/common/estimator_status.hpp"
#include "mavlink/common/local_position_ned.hpp"
#include "mavlink/common/mission_item_reached.hpp"
#include "mavlink/common/set_gps_global_origin.hpp"
#include "mavlink/common/table.hpp"
#include "mavlink_gen/services/address.hpp"
#include "mavlink_gen/services/station_heartbeat.hpp"

namespace cas::hils {
namespace {

namespace mv = mavlink::common;

/// HEARTBEATs let casd route the vehicle's answers to this station.
constexpr base::Duration kHeartbeatPeriod = std::chrono::seconds(1);

}  // namespace

CompanionStation::CompanionStation(mav::Source vehicle, Send send)
    : vehicle_(vehicle),
      send_(std::move(send)),
      parser_(mv::table()),
      mission_([this](const mav::services::MissionExchange::Message& message) {
        std::visit([this](const auto& m) { say(m); }, message);
      }) {}

template <class Message>
void CompanionStation::say(Message message) {
  send_(encode_(mav::services::addressed(message, vehicle_)));
}

void CompanionStation::on_bytes(std::span<const std::uint8_t> bytes, base::RunTime now) {
  parser_.feed(bytes, [&](const mav::PacketView& packet) { on_packet(packet, now); });
}

void CompanionStation::on_packet(const mav::PacketView& packet, base::RunTime now) {
  if (packet.source != vehicle_) return;
  if (const auto position = mav::decode<mv::LocalPositionNed>(packet)) {
    return on_vehicle_time(position->time_boot_ms);
  }
  if (const auto attitude = mav::decode<mv::Attitude>(packet)) {
    return on_vehicle_time(attitude->time_boot_ms);
  }
  if (const auto item = mav::decode<mv::MissionItemReached>(packet)) {
    reached_ = std::max(reached_.value_or(0), item->seq);
    return;
  }
  if (const auto status = mav::decode<mv::EstimatorStatus>(packet)) {
    return on_estimator(status->flags);
  }
  mission_.on_packet(packet, kSelf, now);
}

/// Messages of one moment, and of the moment before, come in any order.
void CompanionStation::on_vehicle_time(std::uint32_t boot_ms) {
  const base::Duration time = std::chrono::milliseconds(boot_ms);
  if (vehicle_time_ && time <= *vehicle_time_) return;
  vehicle_time_ = time;
  if (const auto setpoint = setpoints_.update(time)) say(*setpoint);
  if (auto sticks = sticks_.update(time)) {
    sticks->target = vehicle_.system;
    send_(encode_sticks_(*sticks));
  }
}

void CompanionStation::on_estimator(mv::EstimatorStatusFlags flags) {
  using F = mv::EstimatorStatusFlags;
  const bool is_local = (flags & F::kPosHorizRel) != F{} && (flags & F::kPosHorizAbs) == F{};
  if (!origin_ || !is_local) return;
  mv::SetGpsGlobalOrigin message;
  message.target_system = vehicle_.system;
  message.latitude = base::deg_e7(origin_->lat_deg);
  message.longitude = base::deg_e7(origin_->lon_deg);
  message.set_altitude_m(origin_->alt_m);
  send_(encode_(message));
}

void CompanionStation::tick(base::RunTime now) {
  mission_.tick(now);
  if (now < next_heartbeat_) return;
  next_heartbeat_ = now + kHeartbeatPeriod;
  send_(encode_(mav::services::station_heartbeat(mv::MavType::kOnboardController)));
}

void CompanionStation::upload(mav::services::MissionExchange::Items items, base::RunTime now) {
  uploaded_.reset();
  reached_.reset();
  mission_.upload(std::move(items), now,
                  [this](const mav::services::Outcome& outcome, const auto&) {
                    uploaded_ = outcome;
                    reached_.reset();  // earlier items belong to the old mission
                  });
}

void StickStream::hold(const Sticks& sticks) {
  if (sticks_ != sticks) since_.reset();
  sticks_ = sticks;
}

std::optional<mavlink::common::ManualControl> StickStream::update(base::Duration vehicle_time) {
  if (!sticks_ || !gate_.due(vehicle_time)) return std::nullopt;
  if (!since_) since_ = vehicle_time;
  newest_ = vehicle_time;
  if (lost_) return std::nullopt;
  return manual_control(*sticks_);
}

}  // namespace cas::hils
