// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "casd/topology/topology.hpp"

namespace cas::casd {

/// A sentence for each route over which somebody could fly the vehicle with sensor data of his own:
/// it leads to a flight controller (a serial line, or where another route names HIL_SENSOR), does
/// not name HIL_SENSOR itself, and neither it nor `accept` of its source keeps HIL_SENSOR out.
std::vector<std::string> injection_warnings(const Topology& topology);

}  // namespace cas::casd
