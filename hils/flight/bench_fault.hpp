// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "base/config/config.hpp"
#include "base/time/clock.hpp"
#include "fcu/line/line_model.hpp"
#include "hils/flight/flight_facts.hpp"
#include "hils/flight/flight_plan.hpp"
#include "hils/flight/flight_step.hpp"

namespace cas::hils {

/// Delay of a thread's wake-up after its event, on a machine of the virtual clock: log-normal,
/// given by its median and its 99th percentile. Both zero: at once.
struct WakeUpFigures {
  double p50_us = 0;
  double p99_us = 0;
};
/// @throws base::ConfigError
WakeUpFigures parse_wake_up(const base::ConfigNode& node);

/// The serial line gets other properties while it lasts.
struct LineFault {
  fcu::LineConfig line;
};
/// The serial line's plug is pulled; put back at the end.
struct UnplugFault {};
/// casd is killed, and started again at the end.
struct RestartFault {};
/// The ground station sends so many packets a second.
struct FloodFault {
  double packets_hz = 0;
};
/// Nothing comes from the ground any more: neither the ground station nor casd's own, on the
/// virtual clock; or no sticks: the radio is lost.
struct SilenceFault {
  bool sticks = false;  ///< they alone are silent
};
/// The threads of casd wake up this late: others have the processor. On the virtual clock.
struct StarveFault {
  WakeUpFigures wake_up;
};
/// casd reads its topology again. Needs casd as a program.
struct ReloadFault {};
/// hilsim pauses for this time by the wall clock. Simulated time pauses with it, so by simulated
/// time the fault ends as it begins. With stock firmware.
struct PauseFault {
  base::Duration wall{};
};
/// casd closes a link of its topology, and opens it again at the end. With stock firmware.
struct CutFault {
  std::string link;
};
using BenchFaultKind = std::variant<LineFault, UnplugFault, RestartFault, FloodFault, SilenceFault,
                                    StarveFault, ReloadFault, PauseFault, CutFault>;

/// A fault of the bench, not of the vehicle: its begin, duration and effect.
struct BenchFault {
  std::string name;
  std::size_t vehicle = 0;  ///< whom its condition asks, and whose line it is
  std::optional<base::SimTime> at;
  std::optional<Condition> when;
  base::Duration lasting{};
  BenchFaultKind kind;

  /// Whether it hits every vehicle: a fault of casd or on the ground.
  bool is_everybodys() const;
};

/// A fault that plugin `fault` plays, as it reads it.
struct VehicleFault {
  base::ConfigNode script;
  std::optional<std::size_t> vehicle{};  ///< nullopt: each of them has it
};

/// The faults of a scenario: those of the bench, and those of the vehicles.
struct ScenarioFaults {
  std::vector<BenchFault> bench;
  std::vector<VehicleFault> vehicle;
  bool empty() const { return bench.empty() && vehicle.empty(); }
  /// The faults that plugin `fault` of one vehicle plays.
  std::vector<VehicleFault> of_vehicle(std::size_t vehicle) const;
};

/// Reads the list `faults` of a scenario. Every entry has at_s or when, and one effect; the bench's
/// are `line`, `unplug`, `restart`, `flood_hz`, `silence`, `starve`, `reload`, `pause` and `cut`,
/// all others are plugin fault's. One that names no vehicle hits each of them, by its own
/// condition.
///
/// @param line  the scenario's line, whose keys those of a line fault override
/// @param names  vehicles that a fault may name
/// @throws base::ConfigError
ScenarioFaults parse_scenario_faults(const base::ConfigNode& faults, const base::ConfigNode& line,
                                     const VehicleNames& names = only_vehicle());

/// Refuses the faults of a list that have one of these keys. @throws base::ConfigError at the key
void refuse_faults(const base::ConfigNode& faults, std::span<const std::string_view> keys,
                   const std::string& why);

/// Decides when faults of the bench begin and end. Each happens once in a run. Pure.
class BenchFaultScript {
 public:
  BenchFaultScript() = default;
  explicit BenchFaultScript(std::vector<BenchFault> faults);

  struct Event {
    const BenchFault* fault = nullptr;
    bool begins = false;
  };
  /// One more, ordered in flight.
  void add(BenchFault fault);
  /// One more, which has been begun by hand.
  void add_begun(BenchFault fault, base::SimTime now);
  /// Faults that begin or end now. Its pointers to faults stay valid until the next add().
  std::vector<Event> update(base::SimTime now, std::span<const VehicleReport> vehicles,
                            std::string_view phase);

  /// Whether a fault of this vehicle's line is under way.
  bool line_is_faulty(std::size_t vehicle) const;
  /// The properties that this vehicle's line has now: of the fault under way that began last;
  /// nothing: its own.
  const LineFault* line_of(std::size_t vehicle) const;

  /// One fault as it went.
  struct Span {
    std::string name;
    base::SimTime begin;
    std::optional<base::SimTime> end;
    std::optional<std::size_t> vehicle{};  ///< nullopt: it hit all of them
  };
  /// Faults that hit one vehicle.
  std::vector<Span> history_of(std::size_t vehicle) const;

 private:
  struct Entry {
    BenchFault fault;
    std::optional<std::size_t> span;  ///< its place in the history, once it has begun
    bool over = false;
  };
  void note_begin(Entry& entry, base::SimTime now);
  static bool is_due(const BenchFault& fault, base::SimTime now,
                     std::span<const VehicleReport> vehicles, std::string_view phase);

  std::vector<Entry> entries_;
  std::vector<Span> history_;
};

}  // namespace cas::hils
