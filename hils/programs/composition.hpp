// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <string>

#include "fcu/line/line_model.hpp"
#include "hils/run/run_paths.hpp"
#include "hils/run/run_request.hpp"

namespace cas::hils {

/// Rate of the simulator's record of the truth.
inline constexpr double kTruthHz = 100;

/// How the simulator's interface plugin hands over its packets.
enum class Transport { kUdp, kBus };

/// The configuration of hilsim for a run, as YAML text.
std::string simulator_config(const RunRequest& request, Transport transport, const RunPaths& paths);
/// The configuration of fcu_emulator (and of the controller on the virtual clock), as YAML text.
///
/// @param vehicle  whose, by its place in the scenario
std::string fcu_config(const RunRequest& request, std::size_t vehicle = 0);
/// The topology of casd, as YAML text.
std::string casd_config(const RunRequest& request, const RunPaths& paths);
/// The serial line of a run: the scenario's with the request's preset; ideal without a line.
fcu::LineConfig line_of(const RunRequest& request);
/// Writes them all into `paths.run`. @throws base::ConfigError
void write_configs(const RunRequest& request, Transport transport, const RunPaths& paths);

}  // namespace cas::hils
