// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

namespace cas::casd {
class GainMap;
}

namespace cas::hils {

struct RunRecord;

/// A call that changed a vehicle or the run, or was to; not one of hils's own.
struct OutsideCall {
  std::int64_t log_us = 0;  ///< when, by the clock of the flight log
  std::string client;       ///< caller: "unix:uid 1000"
  std::string method;
  std::string params;       ///< JSON
  std::uint8_t system = 0;  ///< 0: the run as a whole
  bool accepted = true;
  std::string port = "casd's command port";  ///< where it was asked
  std::optional<double> sim_s{};             ///< when, where the simulated time was noted
};

/// The calls in an answer of casd.journal or sim.journal without those of hils.
/// @param own  client of hils's calls, as it introduced itself @param port  of the calls, for
/// people
std::vector<OutsideCall> outside_calls(const nlohmann::json& journal, const std::string& own,
                                       const std::string& port = "casd's command port");

/// Stands for the calls that a full journal has dropped: their effect is unknown, so they count as
/// a call from outside. nullopt: the journal is complete. @param journal  as above
std::optional<OutsideCall> forgotten_calls(const nlohmann::json& journal, const std::string& port);

/// Whether the call does something, and asks no mere question.
bool is_act(const OutsideCall& call);

/// A parameter of a vehicle that got another value during a run.
struct ParameterChange {
  double time_s = 0;  ///< simulated
  std::string by;     ///< "scenario, step 'setgain'", "casd's command port (unix:uid 1000)"
  std::string parameter;
  std::string loop;              ///< "velocity P"; empty: no gain of a loop
  std::optional<double> before;  ///< nullopt: never reported
  double after = 0;
  bool from_outside = false;  ///< neither the scenario nor the vehicle itself did it
};

/// A command that neither the scenario nor hils gave; the same again counts up.
struct OutsideAct {
  double time_s = 0;  ///< simulated, of the first
  std::string by;
  std::string what;
  std::uint64_t times = 1;
};

/// Changes to a flight beside its plan.
struct FlightChanges {
  std::vector<ParameterChange> parameters;
  std::vector<OutsideAct> acts;

  /// Whether anyone beside the scenario acted on the flight.
  bool from_outside() const;
};

/// Reads the flight log of a run: PARAM_VALUEs that differ from the ones before, and commands of
/// ground stations; adds the calls of casd's command port and of the simulator. Parameters by which
/// the scenario flies a trajectory are left out. Without a log there is nothing but the calls.
///
/// @param gains  names the loops that parameters belong to
/// @param own_station  hils itself played a ground station with centred sticks
FlightChanges flight_changes(const RunRecord& record, const casd::GainMap& gains, bool own_station);

}  // namespace cas::hils
