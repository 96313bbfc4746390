// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "hils/measure/measurement.hpp"
#include "hils/report/plot.hpp"

namespace cas::hils {

using NamedPlots = std::vector<std::pair<std::string, Plot>>;

/// The curves of one vehicle of a run, by short name ("rates", "position_x", ...), on simulated
/// time.
NamedPlots run_plots(const Scenario& scenario, const RunRecord& record, const Measurement& figures);

}  // namespace cas::hils
