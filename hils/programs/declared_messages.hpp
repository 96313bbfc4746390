// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "hils/scenario/scenario.hpp"

namespace cas::hils {

/// Names of the MAVLink messages that a vehicle's simulator sends beside those of every run, each
/// once: BATTERY_STATUS where its file has a battery, ESC_STATUS and ESC_INFO where its motors are
/// circuits, then the declarations of the scenario's further plugins (CAS_PLUGIN_SENDS), in their
/// order. Opens their libraries, where the simulator will find them.
/// @throws base::ConfigError with file and line, for a plugin that is not there or that declares a
/// message it may not send
std::vector<std::string> declared_messages(const Scenario& scenario, std::size_t vehicle);

}  // namespace cas::hils
