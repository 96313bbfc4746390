// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

namespace cas::hils {

/// Every key of Scenario with its default and meaning, as tables in Markdown: what `hils run
/// --keys` prints and docs/config.md shows.
std::string scenario_reference();

}  // namespace cas::hils
