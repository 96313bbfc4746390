// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "casd/topology/topology.hpp"

namespace cas::casd {

/// What a topology comes to, for people: links, routes with their filters, and whether each line
/// carries what can be expected on it. For `casd --check`.
std::string topology_text(const Topology& topology);

/// Reads the other files that a topology names (keys, dialect, gains). @throws base::ConfigError
void check_named_files(const Topology& topology);

}  // namespace cas::casd
