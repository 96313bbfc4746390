// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "hils/scenario/scenario.hpp"

namespace cas::hils {

/// Names of the MAVLink messages that a vehicle's simulator sends in addition to those of every
/// run, each once: BATTERY_STATUS if its file has a battery, then the messages declared by the
/// scenario's further plugins (CAS_PLUGIN_SENDS), in their order. Opens their libraries, on the
/// simulator's search path.
/// @throws base::ConfigError with file and line, for a plugin that is missing or declares a message
/// that it must not send
std::vector<std::string> declared_messages(const Scenario& scenario, std::size_t vehicle);

}  // namespace cas::hils
