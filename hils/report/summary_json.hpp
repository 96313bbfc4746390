// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "hils/measure/judgement.hpp"
#include "hils/measure/measurement.hpp"
#include "hils/measure/run_result.hpp"

namespace cas::hils {

/// The figures of a run for programs, as JSON (docs/config.md names the fields).
std::string summary_json(const Measurement& figures, const Verdict& verdict);
/// Of a run: with several vehicles the common fields, then a list of the vehicles.
std::string summary_json(const RunResult& run);

}  // namespace cas::hils
