// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "hils/measure/run_record.hpp"
#include "hils/run/run_request.hpp"

namespace cas::hils {

/// Flies a scenario that stock firmware flies: starts casd, hilsim and the firmware, and takes the
/// vehicles through their steps through casd.
/// @return a record of each vehicle. @throws RunStopped, base::ConfigError
std::vector<RunRecord> run_firmware(const RunRequest& request);

}  // namespace cas::hils
