// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "hils/firmware/firmware_figures.hpp"
#include "hils/firmware/firmware_scenario.hpp"
#include "hils/measure/judgement.hpp"

namespace cas::hils {

/// The report of a flight of stock firmware as a self-contained HTML file: the verdict, what it was
/// held to, truth and estimate over time, rates and delays that casd saw, the configuration.
std::string firmware_report(const FirmwareScenario& scenario, const FirmwarePlaces& places,
                            const FirmwareFigures& figures, const Verdict& verdict);

}  // namespace cas::hils
