// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

namespace cas::casd {

/// Every key of a topology with its default and meaning, as tables in Markdown: what `casd --keys`
/// prints and docs/reference/config.md shows.
std::string topology_reference();

}  // namespace cas::casd
