// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "hils/firmware/firmware_figures.hpp"
#include "hils/firmware/firmware_scenario.hpp"
#include "hils/programs/supervisor.hpp"

namespace cas::hils {

/// Why a firmware of this version is not flown; empty: it may be. @param version  empty: not told
std::string version_fault(const Firmware& wanted, const std::string& version);
/// Why a flight does not wait for its vehicle any longer; empty: it speaks.
std::string silence_fault(const VehicleReport& vehicle);

/// Flies the steps of a scenario through casd once its programs run, and looks at the true
/// position. @return what is known of the flight before its recordings are read
FirmwareFigures pilot_firmware(const FirmwareScenario& scenario, const FirmwarePlaces& places,
                               Supervisor& supervisor);

}  // namespace cas::hils
