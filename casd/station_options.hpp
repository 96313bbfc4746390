// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "casd/station/vehicle_commander.hpp"
#include "casd/topology/topology.hpp"

/// How casd's own station runs, here and on a virtual clock.
namespace cas::casd {

/// The station's options from the topology; the caller adds names and rates of links.
CommanderOptions commander_options(const Topology& topology);

}  // namespace cas::casd
