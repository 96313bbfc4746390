// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <variant>

#include "base/time/clock.hpp"
#include "casd/packet/intervention.hpp"
#include "casd/packet/link_mask.hpp"
#include "casd/station/notice_limit.hpp"
#include "casd/station/services.hpp"
#include "casd/station/takeoff_height.hpp"
#include "casd/station/vehicle_state.hpp"
#include "mavlink_gen/runtime/packet.hpp"

namespace cas::casd {

/// Commanders of a system id. It outlives the vehicle's state.
struct Hands {
  Interventions interventions;     ///< of others than casd's own station
  std::uint64_t arm_requests = 0;  ///< to arm and to disarm, of all: the newest counts
  std::uint64_t disarms = 0;       ///< requests, of all, that disarm or end the flight
};

/// A vehicle and the requests to it that are under way.
struct KnownVehicle {
  /// @param send  called with the vehicle's state and a message of either exchange
  template <class Send>
  KnownVehicle(VehicleState first, Send send, CommandTiming command_timing,
               ParamTiming param_timing)
      : state(std::move(first)),
        commands([this, send](const auto& message) { send(state, message); }, command_timing),
        params([this, send](const auto& message) { send(state, message); }, param_timing) {}
  /// Ends every request with this outcome.
  void give_up(const Outcome& outcome);

  VehicleState state;
  CommandExchange commands;
  ParamExchange params;
  TakeoffHeight takeoff_height{params, state};
  std::uint64_t texts_seen = 0;
  base::RunTime asked_at{};   ///< when missing messages were last requested
  base::RunTime told_at{};    ///< when a message of a stream came last
  base::Duration beat_at{};   ///< its own clock at the newest HEARTBEAT that was sent
  base::RunTime beat_sent{};  ///< the same by this machine's
  bool contested = false;     ///< the newest notice says that it has a rival
};

/// "vehicle 1".
std::string vehicle_text(const VehicleState& state);

/// Table of vehicles. A vehicle is an autopilot (link or group, peer, system, component) that sends
/// HEARTBEAT, or HIGH_LATENCY2. A second autopilot with a vehicle's system id is its rival. The
/// number of vehicles of a link is bounded; silent ones are forgotten. Pure.
class VehicleTable {
 public:
  using Make = std::function<std::unique_ptr<KnownVehicle>(VehicleState)>;
  using Vehicles = std::map<std::uint8_t, std::unique_ptr<KnownVehicle>>;

  /// @param make       makes the entry of a new vehicle
  /// @param link_name  for sentences; empty: their numbers
  VehicleTable(Make make, std::function<std::string(LinkId)> link_name)
      : make_(std::move(make)), link_name_(std::move(link_name)) {}

  /// Called with each notice.
  void on_notice(std::function<void(const std::string&)> callback) {
    on_notice_ = std::move(callback);
  }

  /// Gives a person a notice on a vehicle, for example on its rival. Any sender with a vehicle's id
  /// can cause notices, so only a few of each id pass in a minute.
  void notice(std::uint8_t system, const std::string& sentence, base::RunTime now);

  /// Takes in a packet. HEARTBEATs make vehicles, and rivals of them; HIGH_LATENCY2 makes vehicles.
  /// @return the vehicle whose autopilot sent it, from its place; nullptr: none
  KnownVehicle* track(const Origin& from, const mav::PacketView& packet, base::RunTime now);
  /// Gives notice of rivals that are gone, and forgets silent vehicles.
  void tick(base::RunTime now);
  /// Forgets vehicles that were heard only on these links, which are gone for good.
  void forget(const LinkMask& links);

  KnownVehicle* find(std::uint8_t system) const;
  /// Commanders of the vehicles of this id so far, also of forgotten ones.
  Hands& hands(std::uint8_t system) { return hands_[system]; }
  const Hands& hands(std::uint8_t system) const { return hands_[system]; }
  const Vehicles& all() const { return vehicles_; }
  /// Whether a vehicle is armed that was heard within the last minute.
  bool any_armed(base::RunTime now) const;
  /// The vehicle a request means: the one named, or the only one there is.
  /// @return its system id, or why there is none
  std::variant<std::uint8_t, Outcome> resolve(std::optional<std::uint8_t> asked) const;
  /// Place of a rival: "link sitl", "another peer of link net".
  std::string place(const VehicleState& state, const Rival& rival) const;

 private:
  KnownVehicle* meet(const Origin& from, const mav::PacketView& packet, base::RunTime now);
  void displace(KnownVehicle& vehicle, const Origin& from, mav::Source source, base::RunTime now);
  bool has_room(LinkId link, base::RunTime now);
  void tell_of_rivals(base::RunTime now);
  void expire(base::RunTime now);
  void drop(std::uint8_t system, const std::string& why);

  Make make_;
  std::function<std::string(LinkId)> link_name_;
  std::function<void(const std::string&)> on_notice_;
  Vehicles vehicles_;
  std::array<Hands, 256> hands_;  ///< by system id
  std::map<std::uint8_t, NoticeLimit> notice_limits_;
};

}  // namespace cas::casd
