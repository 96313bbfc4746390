// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "hils/measure/limit_check.hpp"

namespace cas::hils {

/// A table of the limits of a run: name, value, bound, margin and whether it was kept; headings
/// first. The margin is how far the value is from the bound, negative beyond it, with its share of
/// the bound.
std::vector<std::vector<std::string>> limit_rows(const std::vector<LimitCheck>& checks);

}  // namespace cas::hils
