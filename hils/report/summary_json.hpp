// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "hils/measure/run_result.hpp"

namespace cas::hils {

/// The figures of a run for programs, as JSON (docs/reference/config.md names the fields): what its
/// vehicles have in common, then a list of them.
std::string summary_json(const RunResult& run);

}  // namespace cas::hils
