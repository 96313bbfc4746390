// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "hils/measure/run_record.hpp"
#include "hils/run/run_request.hpp"

namespace cas::hils {

/// Flies a scenario in lockstep: the same processes and connections as in real time, but all of
/// them run on the stream's time, and commands are given while it is stopped. The same seed gives
/// the same bytes, as fast as the machine can.
///
/// @throws RunStopped when a program dies or the user interrupts, base::ConfigError
std::vector<RunRecord> run_in_lockstep(const RunRequest& request);

}  // namespace cas::hils
