// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "hils/firmware/firmware_scenario.hpp"
#include "hils/flight/flight_plan.hpp"
#include "hils/measure/flight_changes.hpp"
#include "hils/measure/incident.hpp"
#include "hils/measure/judgement.hpp"
#include "hils/measure/tracking.hpp"

namespace cas::hils {

/// Figures of a flight of stock firmware.
struct FirmwareFigures {
  std::vector<Stage> stages;
  std::string flight_failure;     ///< a sentence; empty when every step was done
  std::string version;            ///< of the firmware; empty: it did not tell
  int looks = 0;                  ///< at the true position during the measured hold
  double height_error_m = 0;      ///< of its mean
  double drift_m = 0;             ///< farthest from where the hold began, horizontal
  std::optional<RmsFigures> rms;  ///< of the true position about its mean in the measured hold
  double wall_s = 0;
  std::string messages = "[]";  ///< message.list of casd at the flight's end: rates, counts, gaps
  std::string hops = "[]";      ///< link.latency of casd: from one link's read to another's write
  double simulated_s = 0;
  double real_time_factor = 0;
  std::vector<Incident> incidents;  ///< by the true flight
  std::string unwatched;            ///< why nobody could look for incidents; empty: somebody did
  std::uint64_t dropped = 0;        ///< packets, by casd at all its links until the flight's end
  std::uint64_t lost = 0;  ///< packets, by the gaps in the sequence numbers that casd heard
};

/// Looks into the true flight, truth.csv: incidents, and how still the measured hold was.
void add_truth(const std::filesystem::path& truth, FirmwareFigures& figures);
/// Takes over what casd's counters say (link.list).
void add_losses(const nlohmann::json& links, FirmwareFigures& figures);

/// Why a firmware of this version is not flown; empty: it may be. @param version  empty: not told
std::string version_fault(const Firmware& wanted, const std::string& version);
/// Why a flight does not wait for its vehicle any longer; empty: it speaks.
std::string silence_fault(const VehicleReport& vehicle);
/// Why a vehicle that was disarmed is not armed again: somebody else had casd command it; empty:
/// nobody did.
std::string disarm_fault(const std::vector<OutsideCall>& calls);

/// What the flight was held to: that it was completed and recorded, without incidents, and within
/// each limit of the scenario.
Verdict judge(const FirmwareScenario& scenario, const FirmwareFigures& figures);

/// Starts casd, hilsim and the firmware, flies the steps through casd, prints and writes the
/// figures (summary.json, junit.xml, truth.csv); those of an earlier run go first. @return exit
/// code of hils. @throws RunStopped, base::ConfigError
int fly_firmware(const FirmwareScenario& scenario, const std::filesystem::path& out);

}  // namespace cas::hils
