// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "hils/measure/run_record.hpp"
#include "hils/run/run_request.hpp"

namespace cas::hils {

/// Flies one run on the bench that its controller, clock and architecture ask for; architecture
/// `direct` is always computed.
/// @return the record of each vehicle, in the order of the scenario
/// @throws base::ConfigError when the configuration cannot be flown; RunStopped when it was
/// interrupted, or a program ended
std::vector<RunRecord> fly(const RunRequest& request);

}  // namespace cas::hils
