// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

namespace cas::hils {

/// Every key of Scenario with its default and meaning, as tables in Markdown: for `hils run --keys`
/// and docs/reference/config.md.
std::string scenario_reference();

}  // namespace cas::hils
