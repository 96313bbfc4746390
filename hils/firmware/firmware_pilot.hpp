// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "hils/firmware/companion_link.hpp"
#include "hils/firmware/firmware_bench.hpp"
#include "hils/firmware/firmware_figures.hpp"
#include "hils/firmware/firmware_scenario.hpp"

namespace cas::hils {

/// Why a firmware of this version is not flown; nullopt: it may be. @param version  empty: unknown
std::optional<std::string> version_fault(const Firmware& wanted, const std::string& version);
/// Why a flight does not wait for its vehicle any longer; nullopt: it sends.
std::optional<std::string> silence_fault(const VehicleReport& vehicle);

/// Flies the steps of a scenario through casd once its programs run, and looks at the true
/// positions.
/// @param links  of each vehicle, where the scenario needs_companion(); else none
/// @return figures of each vehicle's flight, without those from its recordings
std::vector<FirmwareFigures> pilot_firmware(const FirmwareScenario& scenario,
                                            const FirmwarePlaces& places, FirmwareBench& bench,
                                            std::span<const std::unique_ptr<CompanionLink>> links);

}  // namespace cas::hils
