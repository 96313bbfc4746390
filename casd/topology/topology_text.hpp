// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "casd/topology/topology.hpp"

namespace cas::casd {

/// A topology in words: links, routes with their filters, and whether each line carries its
/// expected load. `casd --check` prints it. Pure.
std::string topology_text(const Topology& topology);

/// Every key of a topology with its default and meaning, as tables in Markdown: what `casd --keys`
/// prints and docs/reference/config.md shows.
std::string topology_reference();

}  // namespace cas::casd
