// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "casd/topology/topology.hpp"

namespace cas::casd {

/// What a topology comes to, for people: links, routes with their filters, and whether each line
/// carries what can be expected on it. `casd --check` prints it. Pure.
std::string topology_text(const Topology& topology);

}  // namespace cas::casd
