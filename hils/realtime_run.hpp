// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "hils/measurement.hpp"
#include "hils/run_request.hpp"

namespace cas::hils {

/// Flies a scenario in real time: hilsim, casd and fcu_emulator as processes, connected by UDP and
/// a pseudo-terminal, commanded through casd's command port.
///
/// @throws RunStopped when a program dies or the user interrupts, base::ConfigError
RunRecord run_in_real_time(const RunRequest& request);

}  // namespace cas::hils
