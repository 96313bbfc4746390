// SPDX-License-Identifier: BSD-3-Clause
#include "casd/station_options.hpp"

namespace cas::casd {

CommanderOptions commander_options(const Topology& topology) {
  CommanderOptions options;
  options.self = topology.self;
  options.heartbeat_hz = topology.commanding.heartbeat_hz;
  options.allow_not_hil = topology.commanding.allow_not_hil;
  options.ask_on_sight = topology.commanding.ask_on_sight;
  if (topology.pace == Pace::kLockstep) {
    // Questions on first sight would depend on thread timing and break same-seed, same-bytes.
    options.ask_on_sight = false;
    // Simulated time is stopped between two steps, so a grace period would never end.
    options.command_timing.text_grace = {};
  }
  return options;
}

}  // namespace cas::casd
