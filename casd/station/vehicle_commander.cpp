// SPDX-License-Identifier: BSD-3-Clause
#include "casd/station/vehicle_commander.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "mavlink/common/autopilot_version.hpp"
#include "mavlink/common/manual_control.hpp"

namespace cas::casd {
namespace {

using namespace mavlink::common;

constexpr std::size_t kMaxVehicles = 32;

/// Whether a HEARTBEAT is a flight controller's: simulators, cameras and companions say
/// MAV_AUTOPILOT_INVALID, ground stations their type.
bool is_vehicle(const Heartbeat& heartbeat) {
  return heartbeat.autopilot != MavAutopilot::kInvalid && heartbeat.type != MavType::kGcs;
}

constexpr std::pair<std::uint32_t, double> kArduPilotStreams[] = {
    {SysStatus::kId, 1},         {ExtendedSysState::kId, 2},  {Attitude::kId, 10},
    {LocalPositionNed::kId, 10}, {GlobalPositionInt::kId, 5}, {HomePosition::kId, 0.5},
};

bool addressed(const CommandAck& ack, mav::Source self) {
  // Older autopilots leave the addressee out.
  if (ack.target_system == 0) return true;
  return ack.target_system == self.system &&
         (ack.target_component == 0 || ack.target_component == self.component);
}

}  // namespace

VehicleCommander::Vehicle::Vehicle(VehicleCommander& owner, mav::Source source, LinkId link)
    : state(source, link),
      commands(
          [this, &owner](const CommandExchange::Message& message) {
            std::visit([&](const auto& each) { owner.send(*this, each); }, message);
          },
          owner.options_.command_timing),
      params(
          [this, &owner](const ParamExchange::Message& message) {
            std::visit([&](const auto& each) { owner.send(*this, each); }, message);
          },
          owner.options_.param_timing) {}

VehicleCommander::VehicleCommander(CommanderOptions options, SendPacket send)
    : options_(options), send_(std::move(send)), encoder_(options.self) {}

void VehicleCommander::on_packet(LinkId link, const mav::PacketView& packet, base::RunTime now) {
  now_ = now;
  if (Vehicle* vehicle = track(link, packet, now)) dispatch(*vehicle, packet, now);
}

/// The vehicle whose autopilot sent the packet; a first HEARTBEAT makes one.
VehicleCommander::Vehicle* VehicleCommander::track(LinkId link, const mav::PacketView& packet,
                                                   base::RunTime now) {
  const auto found = vehicles_.find(packet.source.system);
  if (found != vehicles_.end()) {
    Vehicle& vehicle = *found->second;
    if (packet.source != vehicle.state.source()) return nullptr;
    vehicle.state.on_packet(link, packet, now);
    return &vehicle;
  }
  if (packet.source.system == options_.self.system || vehicles_.size() >= kMaxVehicles) {
    return nullptr;
  }
  const std::optional<Heartbeat> heartbeat = mav::decode<Heartbeat>(packet);
  if (!heartbeat || !is_vehicle(*heartbeat)) return nullptr;
  auto& slot = vehicles_[packet.source.system];
  slot = std::make_unique<Vehicle>(*this, packet.source, link);
  slot->state.on_packet(link, packet, now);
  if (options_.ask_on_sight) ask_on_sight(packet.source.system, now);
  return slot.get();
}

/// What commanding needs to know and a vehicle may not stream by itself.
void VehicleCommander::ask_on_sight(std::uint8_t system, base::RunTime now) {
  for (const std::uint32_t id : {AutopilotVersion::kId, HomePosition::kId}) {
    VehicleCommand request{.id = MavCmd::kRequestMessage};
    request.params[0] = static_cast<float>(id);
    start(system, request, now, [](const Outcome&) {});
  }
  // PX4 streams by itself; ArduPilot sends little more than HEARTBEAT until it is asked.
  if (find(system)->autopilot() != Autopilot::kArduPilot) return;
  for (const auto& [id, hz] : kArduPilotStreams) {
    message_interval(system, id, 1e6 / hz, now, [](const Outcome&) {});
  }
}

void VehicleCommander::dispatch(Vehicle& vehicle, const mav::PacketView& packet,
                                base::RunTime now) {
  switch (packet.message_id) {
    case CommandAck::kId:
      if (const auto ack = mav::decode<CommandAck>(packet); ack && addressed(*ack, options_.self)) {
        vehicle.commands.on_ack(*ack, now);
      }
      break;
    case ParamValue::kId:
      if (const auto value = mav::decode<ParamValue>(packet)) {
        vehicle.params.on_value(*value, vehicle.state.param_encoding(), now);
      }
      break;
    case Statustext::kId:
      on_status_text(vehicle);
      break;
    default:
      break;
  }
}

void VehicleCommander::on_status_text(Vehicle& vehicle) {
  const std::uint64_t count = vehicle.state.status_text_count();
  if (count == vehicle.texts_seen) return;
  vehicle.texts_seen = count;
  const StatusText& text = vehicle.state.status_texts().back();
  vehicle.commands.on_status_text(text.text);
  vehicle.params.on_status_text(text.text);
  if (on_text_) on_text_(vehicle.state, text);
}

void VehicleCommander::tick(base::RunTime now) {
  now_ = now;
  beat(now);
  for (auto& [system, vehicle] : vehicles_) {
    vehicle->commands.tick(now);
    vehicle->params.tick(now);
  }
}

/// Own HEARTBEAT: without one PX4 counts its ground station as lost.
void VehicleCommander::beat(base::RunTime now) {
  if (options_.heartbeat_hz <= 0) return;
  if (!next_beat_) next_beat_ = now;
  if (now < *next_beat_) return;
  const base::Duration period = base::from_seconds(1.0 / options_.heartbeat_hz);
  *next_beat_ += period;
  if (now >= *next_beat_) next_beat_ = now + period;
  Heartbeat message;
  message.type = MavType::kGcs;
  message.autopilot = MavAutopilot::kInvalid;
  message.system_status = MavState::kActive;
  message.mavlink_version = 3;
  send_(encoder_(message));
}

template <class M>
void VehicleCommander::send(const Vehicle& vehicle, M message) {
  const mav::Source target = vehicle.state.source();
  if constexpr (requires { message.target_system; }) {
    message.target_system = target.system;
    message.target_component = target.component;
  } else {
    message.target = target.system;
  }
  send_(encoder_(message));
}

void VehicleCommander::manual_control(std::uint8_t system, const Sticks& sticks, bool not_hil,
                                      base::RunTime now, Done done) {
  Vehicle* vehicle = known(system, done);
  if (vehicle == nullptr || interlocked(*vehicle, not_hil, now, done)) return;
  constexpr double kFull = 1000;
  const auto scaled = [](double stick, double low) {
    return static_cast<std::int16_t>(std::lround(std::clamp(stick, low, 1.0) * kFull));
  };
  mavlink::common::ManualControl message;
  message.x = scaled(sticks.pitch, -1);
  message.y = scaled(sticks.roll, -1);
  message.z = scaled(sticks.throttle, 0);
  message.r = scaled(sticks.yaw, -1);
  message.buttons = sticks.buttons;
  send(*vehicle, message);
  done(Outcome{});
}

const VehicleState* VehicleCommander::find(std::uint8_t system) const {
  const auto found = vehicles_.find(system);
  return found == vehicles_.end() ? nullptr : &found->second->state;
}

std::vector<const VehicleState*> VehicleCommander::vehicles() const {
  std::vector<const VehicleState*> all;
  for (const auto& [system, vehicle] : vehicles_) all.push_back(&vehicle->state);
  return all;
}

std::variant<std::uint8_t, Outcome> VehicleCommander::resolve(
    std::optional<std::uint8_t> asked) const {
  if (vehicles_.empty()) {
    return failure(OutcomeKind::kNoSuchVehicle,
                   "no vehicle has been heard yet; is its link up and does it send HEARTBEAT?");
  }
  std::string known;
  for (const auto& [system, vehicle] : vehicles_) {
    known += (known.empty() ? "" : ", ") + std::to_string(system);
  }
  if (asked && !vehicles_.contains(*asked)) {
    return failure(OutcomeKind::kNoSuchVehicle,
                   "no vehicle " + std::to_string(*asked) + " has been heard; known: " + known);
  }
  if (!asked && vehicles_.size() > 1) {
    return failure(OutcomeKind::kInvalid, "name the vehicle; known: " + known);
  }
  return asked ? *asked : vehicles_.begin()->first;
}

VehicleCommander::Vehicle* VehicleCommander::known(std::uint8_t system, const Done& done) {
  const auto found = vehicles_.find(system);
  if (found != vehicles_.end()) return found->second.get();
  done(
      failure(OutcomeKind::kNoSuchVehicle, "no vehicle " + std::to_string(system) + " has been heard"));
  return nullptr;
}

void VehicleCommander::start(std::uint8_t system, const VehicleCommand& command, base::RunTime now,
                             Done done) {
  now_ = now;
  if (Vehicle* vehicle = known(system, done)) {
    vehicle->commands.start(command, now, std::move(done));
  }
}

}  // namespace cas::casd
