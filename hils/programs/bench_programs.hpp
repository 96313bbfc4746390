// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "hils/programs/run_programs.hpp"

namespace cas::hils {

/// The programs of a run without stock firmware: hilsim, casd and a controller for each vehicle.
class BenchPrograms {
 public:
  /// All outlive it. A controller is fcu_emulator where the request names no device.
  BenchPrograms(Supervisor& supervisor, const RunPaths& paths, const RunRequest& request)
      : supervisor_(supervisor),
        paths_(paths),
        request_(request),
        programs_(supervisor, paths, request, {.casd_ledger = true}) {}

  /// The controllers first (they make the PTYs), then casd, then the simulator, which starts the
  /// stream; one that is paused loads at the same time as the controllers. @throws RunStopped,
  /// base::ConfigError
  /// @param paused  the simulator waits at time zero
  void start(bool paused = false);
  /// Stops the simulator first, so that its last packets still arrive. @throws RunStopped on bad
  /// ends
  /// @param nothing_under_way  as at the end of lockstep: casd ends at the same time
  void stop(bool nothing_under_way = false);

  /// Kills casd at once, as a fault of the scenario.
  void kill_casd() { programs_.kill_casd(); }
  void start_casd() { programs_.start_casd(); }

 private:
  void launch_emulator(const VehiclePaths& paths);

  Supervisor& supervisor_;
  const RunPaths& paths_;
  const RunRequest& request_;
  RunPrograms programs_;
  std::vector<ChildProcess*> emulators_;
};

}  // namespace cas::hils
