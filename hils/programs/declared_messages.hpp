// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "hils/scenario/scenario.hpp"

namespace cas::hils {

/// Names of the MAVLink messages that a scenario's further plugins declare (CAS_PLUGIN_SENDS), each
/// once, in the order of the plugins. Opens their libraries, where the simulator will find them.
/// @throws base::ConfigError with file and line, for a plugin that is not there or that declares
/// what it may not send
std::vector<std::string> declared_messages(const Scenario& scenario);

}  // namespace cas::hils
