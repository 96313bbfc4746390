// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <vector>

#include "hils/report/plot.hpp"

namespace cas::hils {

/// The true northward motion after each `trajectory: {shape: step}` of a scenario, in two flights
/// of it: a plot for each step, both curves from its beginning. A flight that did not come so far,
/// or left no truth.csv and summary.json, has no curve.
std::vector<Plot> step_plots(const std::filesystem::path& scenario,
                             const std::filesystem::path& before,
                             const std::filesystem::path& after);

}  // namespace cas::hils
