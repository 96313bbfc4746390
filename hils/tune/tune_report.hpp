// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "hils/report/document.hpp"
#include "hils/tune/tune_run.hpp"

namespace cas::hils {

/// The candidates of `rows` as CSV: number, parameters, objectives, guards, penalty, weighted sum.
std::string candidates_csv(const TuneStudy& study, const TuneResult& result,
                           const std::vector<std::size_t>& rows);

/// The values as YAML: `params` as in a controller file (and below `controller` of a scenario), all
/// other key paths in `set`, as in a study.
std::string gains_yaml(const TuneStudy& study, const Candidate& candidate);

/// Lines NAME VALUE of the parameters among the values, for `casctl param load`; empty where none
/// is a parameter of the controller.
std::string gains_params(const TuneStudy& study, const Candidate& candidate);

/// Verdict, values, objectives and guards before and after, verification; on a page also step
/// responses and front.
/// @param steps  plots of the step responses
Document tune_report(const TuneStudy& study, const TuneResult& result,
                     const std::vector<Plot>& steps);

}  // namespace cas::hils
