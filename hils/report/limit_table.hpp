// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "hils/measure/limit_check.hpp"

namespace cas::hils {

/// A table of a run's checks: name, value, bound, margin and result; headings first. The
/// margin is the distance from the bound, negative beyond it, also as a share of the
/// bound.
std::vector<std::vector<std::string>> limit_rows(const std::vector<LimitCheck>& checks);

}  // namespace cas::hils
