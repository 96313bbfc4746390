// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>

#include "hils/measurement.hpp"
#include "hils/scenario.hpp"

namespace cas::hils {

/// Flies a scenario in real time: hilsim, casd and fcu_emulator as processes, connected by UDP and
/// a pseudo-terminal, commanded through casd's command port.
///
/// @param out  folder for the results; effective configurations and figures go to out/run
/// @throws RunStopped when a program dies or the user interrupts, base::ConfigError
RunRecord run_tcas(const Scenario& scenario, std::uint64_t seed, const std::filesystem::path& out);

}  // namespace cas::hils
