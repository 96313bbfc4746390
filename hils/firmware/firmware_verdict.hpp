// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <span>
#include <string>

#include "hils/firmware/firmware_figures.hpp"
#include "hils/firmware/firmware_scenario.hpp"
#include "hils/measure/judgement.hpp"

namespace cas::hils {

/// Checks that the flight was completed and recorded, without incidents and within each limit of
/// the scenario.
Verdict judge(const FirmwareScenario& scenario, const FirmwareFigures& figures);
/// One vehicle of a flight.
struct FirmwareResult {
  std::string vehicle;  ///< its name
  FirmwareFigures figures;
  Verdict verdict;
};
/// The verdict on all of them: passed when each has.
Verdict judge_together(std::span<const FirmwareResult> vehicles);
/// summary.json of a flight of stock firmware; of several vehicles the shared part, and a list.
nlohmann::json firmware_summary(const FirmwareScenario& scenario,
                                std::span<const FirmwareResult> vehicles);

}  // namespace cas::hils
