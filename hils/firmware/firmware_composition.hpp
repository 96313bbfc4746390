// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <string>

#include "hils/run/run_paths.hpp"
#include "hils/run/run_request.hpp"

namespace cas::hils {

/// Name of casd's link for hils's own packets to a vehicle.
std::string companion_link_name(std::size_t vehicle);

/// Whether a flight has steps that hils flies on a link of its own: trajectories, missions,
/// breaches.
bool needs_companion(const Scenario& scenario);

/// Whether a board can fly the scenario of a stock firmware: of one by External AHRS the list of
/// boards says where its sensors' line is, and that nothing is connected to its outputs; faults of
/// the emulated line have no place. @throws base::ConfigError
void check_firmware_board(const RunRequest& request);

/// Writes the scenario's world and topology as the programs are given them: with the run's seed, a
/// recorder, control sockets in the run's folder and casd's serial link at the firmware's line.
/// @throws base::ConfigError
void write_firmware_configs(const RunRequest& request, const RunPaths& paths);

}  // namespace cas::hils
