// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "hils/firmware/companion_link.hpp"
#include "hils/firmware/firmware_bench.hpp"
#include "hils/measure/run_record.hpp"
#include "hils/run/run_request.hpp"

namespace cas::hils {

/// Why a flight does not wait for its vehicle any longer; nullopt: it sends.
std::optional<std::string> silence_fault(const VehicleReport& vehicle);

/// Flies the steps of a scenario through casd once its programs run, and looks at the true
/// positions.
/// @param links  of each vehicle, where the scenario needs_companion(); else none
/// @param records  of the vehicles, which it fills in, but for what the programs leave behind
void pilot_firmware(const RunRequest& request, const RunPaths& paths, FirmwareBench& bench,
                    std::span<const std::unique_ptr<CompanionLink>> links,
                    std::vector<RunRecord>& records);

}  // namespace cas::hils
