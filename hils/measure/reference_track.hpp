// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "hils/measure/run_record.hpp"

namespace cas::hils {

/// Where the vehicle was to be, in the axes of the truth, from its first climb to its landing but
/// for transitions: on a circle the nearest point of it.
/// @param period_s  between two samples of a stage
std::vector<PoseSample> reference_track(const RunRecord& record, double period_s);

}  // namespace cas::hils
