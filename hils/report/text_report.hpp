// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "hils/measure/judgement.hpp"
#include "hils/measure/measurement.hpp"
#include "hils/measure/run_result.hpp"

namespace cas::hils {

/// Verdict and figures for people: tables as [HILS] Tables 4 and 5, with its rows below ours.
std::string text_report(const Measurement& figures, const Verdict& verdict);
/// Of a run: with several vehicles the verdict on all, a line for each, then the figures of each.
std::string text_report(const RunResult& run);

}  // namespace cas::hils
