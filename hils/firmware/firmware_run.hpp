// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "hils/firmware/firmware_scenario.hpp"
#include "hils/flight/flight_plan.hpp"

namespace cas::hils {

/// Figures of a flight of stock firmware.
struct FirmwareFigures {
  std::vector<Stage> stages;
  std::string flight_failure;  ///< a sentence; empty when every step was done
  int looks = 0;               ///< at the true position during the measured hold
  double height_error_m = 0;   ///< of its mean
  double drift_m = 0;          ///< farthest from where the hold began, horizontal
  double simulated_s = 0;
  double real_time_factor = 0;
};

/// Compares figures with the scenario's limits: a sentence for each that was missed.
std::vector<std::string> misses(const FirmwareScenario& scenario, const FirmwareFigures& figures);

/// Starts casd, hilsim and the firmware, flies the steps through casd, prints and writes the
/// figures (summary.json, truth.csv). @return exit code of hils. @throws RunStopped,
/// base::ConfigError
int fly_firmware(const FirmwareScenario& scenario, const std::filesystem::path& out);

}  // namespace cas::hils
