// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "hils/scenario/scenario.hpp"

namespace cas::hils {

/// Reads `line`, `controller`, `sensors` and the names of `plugins` of a scenario with the readers
/// of simulator and controller, so that an error names the line of the scenario before a program is
/// started. Keys of further plugins are read by the plugins, when they start.
/// @throws base::ConfigError
void check_handed_on_keys(const Scenario& scenario);
/// Refuses `sensors` of a scenario of stock firmware for which the simulation has no plugin. hilsim
/// reads their keys. @throws base::ConfigError
void check_firmware_sensors(const Scenario& scenario);

}  // namespace cas::hils
