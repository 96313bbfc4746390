// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "casd/topology/topology.hpp"

namespace cas::casd {

/// A sentence for each route over which somebody could fly the vehicle with sensor data of his own:
/// it leads to a flight controller (a serial line, or where another route names HIL_SENSOR), does
/// not name HIL_SENSOR itself, and neither it nor `accept` of its source keeps HIL_SENSOR out.
///
/// And one for each link of which any host may have failures strike in the simulator: it has
/// `inject_failures`, listens on more than this machine and verifies no signatures.
std::vector<std::string> injection_warnings(const Topology& topology);

/// Whether MAV_CMD_INJECT_FAILURE of a station on this link may pass: `inject_failures`, and
/// `accept` keeps neither COMMAND_LONG nor COMMAND_INT out.
bool may_inject_failures(const LinkConfig& link);

}  // namespace cas::casd
