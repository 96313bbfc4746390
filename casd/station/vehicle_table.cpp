// SPDX-License-Identifier: BSD-3-Clause
#include "casd/station/vehicle_table.hpp"

#include <fmt/format.h>
#include <algorithm>
#include <utility>

#include "base/text.hpp"
#include "mavlink_gen/runtime/codec.hpp"
#include "mavlink_gen/services/vehicle_heartbeat.hpp"

namespace cas::casd {
namespace {

using namespace mavlink::common;

/// Vehicles of one link, of the 255 ids that MAVLink has.
constexpr std::size_t kMaxVehiclesPerLink = 250;
/// Silence after which a disarmed vehicle is forgotten, and an armed one where room is needed.
constexpr base::Duration kForgetAfter = std::chrono::seconds(60);

/// Whether the sender of a HEARTBEAT replaces the vehicle: component 1 replaces any other at once,
/// the same component a vehicle that has fallen silent.
bool takes_over(const VehicleState& vehicle, mav::Source source, base::Duration silence,
                base::RunTime now) {
  const std::uint8_t held = vehicle.source().component;
  if (source.component != held) return source.component == mav::services::kAutopilot;
  return vehicle.heartbeat_age(now) > silence;
}

/// Silence after which a vehicle counts as gone.
base::Duration patience(const VehicleState& vehicle) {
  return std::max(kForgetAfter, vehicle.silent_after());
}

/// The HEARTBEAT in a packet of a vehicle, or the one made from HIGH_LATENCY2; else nullopt.
std::optional<Heartbeat> presence(const mav::PacketView& packet) {
  std::optional<Heartbeat> heartbeat = mav::decode<Heartbeat>(packet);
  if (const auto slow = mav::decode<HighLatency2>(packet)) {
    heartbeat = mav::services::heartbeat_of(*slow, {});
  }
  if (heartbeat && !mav::services::is_vehicle(packet.source, *heartbeat)) return std::nullopt;
  return heartbeat;
}

}  // namespace

void KnownVehicle::give_up(const Outcome& outcome) {
  commands.give_up(outcome);
  params.give_up(outcome);
}

std::string vehicle_text(const VehicleState& state) {
  return fmt::format("vehicle {}", state.source().system);
}

KnownVehicle* VehicleTable::track(const Origin& from, const mav::PacketView& packet,
                                  base::RunTime now) {
  KnownVehicle* vehicle = find(packet.source.system);
  if (packet.message_id == Heartbeat::kId || packet.message_id == HighLatency2::kId) {
    if (!presence(packet)) return nullptr;
    vehicle = meet(from, packet, now);
  }
  if (vehicle == nullptr || vehicle->state.source() != packet.source ||
      !vehicle->state.is_at(from, now)) {
    return nullptr;
  }
  vehicle->state.on_packet(from, packet, now);
  return vehicle;
}

bool VehicleTable::any_armed(base::RunTime now) const {
  return std::any_of(vehicles_.begin(), vehicles_.end(), [now](const auto& entry) {
    const VehicleState& state = entry.second->state;
    return state.armed() && state.heartbeat_age(now) <= patience(state);
  });
}

void VehicleTable::tick(base::RunTime now) {
  tell_of_rivals(now);
  expire(now);
}

/// An autopilot sent HEARTBEAT or HIGH_LATENCY2. @return the vehicle of its system id; this may be
/// another autopilot
KnownVehicle* VehicleTable::meet(const Origin& from, const mav::PacketView& packet,
                                 base::RunTime now) {
  const mav::Source source = packet.source;
  const bool slow = packet.message_id == HighLatency2::kId;
  const auto found = vehicles_.find(source.system);
  if (found == vehicles_.end()) {
    if (!has_room(from.path.link, now)) return nullptr;
    auto& slot = vehicles_[source.system];
    slot = make_(VehicleState(source, from, now));
    return slot.get();
  }
  KnownVehicle& vehicle = *found->second;
  const bool here = vehicle.state.is_at(from, now);
  if (here && source == vehicle.state.source()) return &vehicle;
  const base::Duration silence = slow ? vehicle.state.silent_after() : kVehicleTimeout;
  if (takes_over(vehicle.state, source, silence, now) &&
      (from.path.link == vehicle.state.link() || has_room(from.path.link, now))) {
    displace(vehicle, from, source, now);
    return vehicles_.at(source.system).get();
  }
  // A vehicle with a satellite modem is not its own rival.
  if (!here && !slow) {
    vehicle.state.on_rival({source, from, now});
    if (!vehicle.contested) tell_of_rivals(now);
  }
  return &vehicle;
}

/// Another autopilot is the vehicle of this id from now on; the state of the old one is dropped.
void VehicleTable::displace(KnownVehicle& vehicle, const Origin& from, mav::Source source,
                            base::RunTime now) {
  const VehicleState& old = vehicle.state;
  auto next = make_(VehicleState(source, from, now));
  if (!next->state.is_at(old.origin(), now) && old.heartbeat_age(now) <= kVehicleTimeout) {
    next->state.on_rival({old.source(), old.origin(), old.heartbeat().at});
  } else if (const auto rival = old.rival(now); rival && !next->state.is_at(rival->from, now)) {
    next->state.on_rival(*rival);
  }
  next->contested = vehicle.contested;
  const std::unique_ptr<KnownVehicle> gone =
      std::exchange(vehicles_.at(source.system), std::move(next));
  gone->give_up(
      failure(OutcomeKind::kTimeout, "another autopilot took the place of " + vehicle_text(old)));
  tell_of_rivals(now);
}

/// Whether the link may have one more vehicle. The one that was silent longest makes room.
bool VehicleTable::has_room(LinkId link, base::RunTime now) {
  std::size_t count = 0;
  const VehicleState* oldest = nullptr;
  for (const auto& [system, vehicle] : vehicles_) {
    const VehicleState& state = vehicle->state;
    if (state.link() != link) continue;
    ++count;
    if (oldest == nullptr || state.heartbeat_age(now) > oldest->heartbeat_age(now)) oldest = &state;
  }
  if (count < kMaxVehiclesPerLink) return true;
  if (oldest->heartbeat_age(now) <= patience(*oldest)) return false;
  drop(oldest->source().system, " fell silent");
  return true;
}

/// Gives one notice when a rival appears, and one when it is gone.
void VehicleTable::tell_of_rivals(base::RunTime now) {
  for (const auto& [system, vehicle] : vehicles_) {
    const std::optional<Rival> rival = vehicle->state.rival(now);
    if (rival.has_value() == vehicle->contested) continue;
    vehicle->contested = rival.has_value();
    const std::string who = vehicle_text(vehicle->state);
    notice(system,
           rival ? who + " has a rival: another autopilot with this system id speaks on " +
                       place(vehicle->state, *rival) +
                       "; casd arms neither until one of them is silent"
                 : who + " is alone again under its system id",
           now);
  }
}

void VehicleTable::notice(std::uint8_t system, const std::string& sentence, base::RunTime now) {
  constexpr int kMost = 10;
  if (!on_notice_) return;
  NoticeLimit& limit = notice_limits_.try_emplace(system, kMost).first->second;
  if (!limit.take(now)) return;
  on_notice_(limit.is_last() ? sentence + "; no more notices of it for a minute" : sentence);
}

void VehicleTable::expire(base::RunTime now) {
  std::vector<std::uint8_t> silent;
  for (const auto& [system, vehicle] : vehicles_) {
    const VehicleState& state = vehicle->state;
    if (!state.armed() && state.heartbeat_age(now) > patience(state)) silent.push_back(system);
  }
  for (const std::uint8_t system : silent) drop(system, " fell silent");
}

void VehicleTable::forget(const LinkMask& links) {
  std::vector<std::uint8_t> lost;
  for (const auto& [system, vehicle] : vehicles_) {
    if (!vehicle->state.forget(links)) lost.push_back(system);
  }
  for (const std::uint8_t system : lost) drop(system, " was on a link that is gone");
}

void VehicleTable::drop(std::uint8_t system, const std::string& why) {
  const auto gone = vehicles_.extract(system);
  gone.mapped()->give_up(failure(OutcomeKind::kTimeout, vehicle_text(gone.mapped()->state) + why));
}

/// "link sitl", "another peer of link net".
std::string VehicleTable::place(const VehicleState& state, const Rival& rival) const {
  const LinkId link = rival.from.path.link;
  const std::string name = link_name_ ? link_name_(link) : std::to_string(link);
  return (link == state.link() ? "another peer of link " : "link ") + name;
}

KnownVehicle* VehicleTable::find(std::uint8_t system) const {
  const auto found = vehicles_.find(system);
  return found == vehicles_.end() ? nullptr : found->second.get();
}

std::variant<std::uint8_t, Outcome> VehicleTable::resolve(std::optional<std::uint8_t> asked) const {
  if (vehicles_.empty()) {
    return failure(OutcomeKind::kNoSuchVehicle,
                   "no vehicle has been heard yet; is its link up and does it send HEARTBEAT?");
  }
  const std::string known = base::joined(
      vehicles_, ", ", [](const auto& vehicle) { return std::to_string(vehicle.first); });
  if (asked && !vehicles_.contains(*asked)) {
    return failure(OutcomeKind::kNoSuchVehicle,
                   fmt::format("no vehicle {} has been heard; known: {}", *asked, known));
  }
  if (!asked && vehicles_.size() > 1) {
    return failure(OutcomeKind::kInvalid, "name the vehicle; known: " + known);
  }
  return asked ? *asked : vehicles_.begin()->first;
}

}  // namespace cas::casd
