// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "hils/measure/run_record.hpp"
#include "hils/run/run_request.hpp"

namespace cas::hils {

/// Flies a scenario in real time: hilsim, casd and an fcu_emulator for each vehicle as processes,
/// connected by UDP and pseudo-terminals, commanded through casd's command port.
///
/// @return one record for each vehicle, in the order of the scenario
/// @throws RunStopped when a program dies or the user interrupts, base::ConfigError
std::vector<RunRecord> run_in_real_time(const RunRequest& request);

}  // namespace cas::hils
