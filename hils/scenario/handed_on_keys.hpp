// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "hils/scenario/scenario.hpp"

namespace cas::hils {

/// Reads the blocks of a scenario that simulator and controller read in flight, with their readers:
/// `line`, `controller`, `sensors` and the names of `plugins`. So an error names the scenario's
/// line before anything is started. The keys of further plugins are read by the plugins alone.
/// @throws base::ConfigError
void check_handed_on_keys(const Scenario& scenario);
/// Finds sensors of a scenario of stock firmware that its simulation does not have. Their keys are
/// read together with those of the simulation's file. @throws base::ConfigError
void check_firmware_sensors(const Scenario& scenario);

}  // namespace cas::hils
