// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "casd/topology/topology.hpp"

namespace cas::casd {

/// A topology in words: links, routes with their filters, and whether each line carries its
/// expected load. `casd --check` prints it. Pure.
std::string topology_text(const Topology& topology);

}  // namespace cas::casd
