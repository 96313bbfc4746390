// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "base/time/clock.hpp"
#include "hils/flight/bench_fault.hpp"
#include "hils/measure/fence_verdict.hpp"
#include "mavlink_gen/runtime/packet.hpp"

namespace cas::hils {

/// hils as a companion computer of stock firmware: the ids of no vehicle (1..), of casd (254/190)
/// and of no usual station (255/190).
inline constexpr mav::Source kCompanion{253, 191};
/// Sender of the companion's sticks: ArduPilot takes those of system SYSID_MYGCS (255) alone.
inline constexpr mav::Source kCompanionSticks{255, 191};

/// The parameters of a vehicle before its first step.
struct ParamDigest {
  std::size_t count = 0;
  std::string sha256{};  ///< of "NAME VALUE" lines in the order of the names
};
/// @param list  `parameters` of param.list
ParamDigest digest_of(const nlohmann::json& list);

/// Setpoints that hils has sent to a vehicle.
struct SetpointFigures {
  std::uint64_t count = 0;
  double longest_gap_s = 0;  ///< between two setpoints of one stream, by the vehicle's clock
};

/// The sensors' line of a vehicle whose autopilot has plugin external_ahrs, for the whole run.
struct AhrsFigures {
  std::uint64_t sent = 0;        ///< packets
  std::uint64_t dropped = 0;     ///< the line, or its reader, had no room for them
  std::uint64_t late = 0;        ///< waited for the line for 1 ms or longer
  std::uint64_t crc_errors = 0;  ///< lines of the driver
  double longest_gap_ms = 0;     ///< between two packets, by the wall clock
};
/// Figures of one vehicle's line from the simulator's statistics; nullopt: it has no such line.
std::optional<AhrsFigures> ahrs_figures(const nlohmann::json& statistics,
                                        const std::string& vehicle);

/// What only a flight of stock firmware has, of one vehicle, beside its RunRecord.
struct FirmwareRecord {
  std::string autopilot{};              ///< of the scenario's world: "PX4"
  std::string version{};                ///< of the firmware; empty: unknown
  std::optional<ParamDigest> params{};  ///< nullopt: they could not be read
  /// The flight failed because the vehicle was disarmed before it took off, where it stood upright.
  bool disarmed_on_ground = false;
  std::optional<FenceFigures> fence{};       ///< of a scenario that has one
  SetpointFigures setpoints{};               ///< none: no trajectory
  std::map<std::string, double> rates_hz{};  ///< of its messages in the hold, simulated time
  std::vector<BenchFaultScript::Span> bench_faults{};  ///< those that the bench played
  /// When its program ended by itself, or the last HEARTBEAT of one that fell silent.
  std::optional<base::SimTime> fell_silent{};
  double real_time_factor = 0;  ///< of the simulator, at the end
  std::string messages = "[]";  ///< message.list of casd at the flight's end
  std::string hops = "[]";      ///< link.latency of casd: from one link's read to another's write
  std::uint64_t dropped = 0;    ///< packets, by casd at all its links until the flight's end
  std::uint64_t lost = 0;       ///< packets, by the gaps in the numbers that casd heard
  std::optional<AhrsFigures> ahrs{};
  std::vector<std::string> remarks{};      ///< of the verdict
  std::vector<std::string> not_its_own{};  ///< why the true motion is another vehicle's
};

/// Adds the losses by casd's counters. @param links  link.list
void add_losses(const nlohmann::json& links, FirmwareRecord& record);
/// The slowest way through casd for 99 % of its packets, us; nullopt: none was timed.
/// @param hops  link.latency
std::optional<double> slowest_hop_us(const nlohmann::json& hops);

}  // namespace cas::hils
