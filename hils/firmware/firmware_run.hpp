// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>

#include "hils/firmware/firmware_scenario.hpp"

namespace cas::hils {

/// Starts casd, hilsim and the firmware, flies the steps through casd, prints and writes the
/// figures (summary.json, junit.xml, report.html, replay.html, truth.csv).
/// @return exit code of hils. @throws RunStopped, base::ConfigError
int fly_firmware(const FirmwareScenario& scenario, const std::filesystem::path& out);

}  // namespace cas::hils
