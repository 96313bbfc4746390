// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>
#include <string>

#include "hils/firmware/firmware_scenario.hpp"
#include "hils/firmware/firmware_verdict.hpp"

namespace cas::hils {

/// The report of a flight of stock firmware as a self-contained HTML file: the verdict, its limits,
/// truth and estimate over time, rates and delays that casd saw, the configuration. Several
/// vehicles have a section each.
std::string firmware_report(const FirmwareScenario& scenario, const FirmwarePlaces& places,
                            std::span<const FirmwareResult> vehicles);

}  // namespace cas::hils
