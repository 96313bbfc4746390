// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "hils/firmware/firmware_figures.hpp"
#include "hils/firmware/firmware_scenario.hpp"
#include "hils/measure/judgement.hpp"

namespace cas::hils {

/// What the flight was held to: that it was completed and recorded, without incidents, and within
/// each limit of the scenario.
Verdict judge(const FirmwareScenario& scenario, const FirmwareFigures& figures);
/// summary.json of a flight of stock firmware.
nlohmann::json firmware_summary(const FirmwareScenario& scenario, const FirmwareFigures& figures,
                                const Verdict& verdict);

}  // namespace cas::hils
