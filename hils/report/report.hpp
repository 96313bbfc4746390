// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

#include "hils/measure/judgement.hpp"
#include "hils/measure/measurement.hpp"
#include "hils/measure/run_result.hpp"
#include "hils/measure/trajectory.hpp"

namespace cas::hils {

/// Verdict and figures for people: tables as [HILS] Tables 4 and 5, with its rows below ours.
std::string text_report(const Measurement& figures, const Verdict& verdict);
/// Of a run: with several vehicles the verdict on all, what each did in a line, then each by
/// itself.
std::string text_report(const RunResult& run);

/// The same figures for programs, as JSON (docs/config.md names the fields).
std::string summary_json(const Measurement& figures, const Verdict& verdict);
/// Of a run: with several vehicles a list of them below what is common to all.
std::string summary_json(const RunResult& run);

/// PASSED, FAILED or INVALID.
std::string_view verdict_word(const Verdict& verdict);
/// One RMS error, such as &RmsFigures::x_m; a dash where the measured step was not reached.
std::string rms_text(const std::optional<RmsFigures>& rms, double RmsFigures::*axis);

}  // namespace cas::hils
