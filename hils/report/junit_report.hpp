// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "hils/measure/run_result.hpp"

namespace cas::hils {

/// The verdict for continuous integration, as JUnit XML: one case when every limit was kept, else
/// one for each that was missed, or for each reason why the run is not valid. Several vehicles have
/// a suite each.
std::string junit_report(const RunResult& run);

}  // namespace cas::hils
