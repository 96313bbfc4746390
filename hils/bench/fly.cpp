// SPDX-License-Identifier: BSD-3-Clause
#include "hils/bench/fly.hpp"

#include "hils/firmware/firmware_run.hpp"
#include "hils/programs/lockstep_run.hpp"
#include "hils/programs/realtime_run.hpp"
#include "hils/virtual/virtual_run.hpp"

namespace cas::hils {

std::vector<RunRecord> fly(const RunRequest& request) {
  if (request.scenario.firmware) return run_firmware(request);
  // A board is flown in its own time, whatever the architecture: a computed flight would be the
  // emulator's.
  if (request.fcu_devices.empty() && request.is_computed()) return run_on_virtual_clock(request);
  if (request.clock == Clock::kLockstep) return run_in_lockstep(request);
  return run_in_real_time(request);
}

}  // namespace cas::hils
