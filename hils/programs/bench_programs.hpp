// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "hils/programs/composition.hpp"
#include "hils/programs/flight_logs.hpp"
#include "hils/programs/supervisor.hpp"

namespace cas::hils {

/// The programs of a run in real time: hilsim, casd and a controller for each vehicle.
class BenchPrograms {
 public:
  /// Both outlive it. A controller is fcu_emulator where the request names no device.
  BenchPrograms(Supervisor& supervisor, const RunPlaces& places, const RunRequest& request)
      : supervisor_(supervisor),
        places_(places),
        request_(request),
        logs_(places.flight_tlog(), places.run) {}

  /// The controllers first (they make the PTYs), then casd, then the simulator, which starts the
  /// stream; one that is paused loads at the same time as the controllers. @throws RunStopped,
  /// base::ConfigError
  /// @param paused  the simulator waits at time zero
  void start(bool paused = false);
  /// Stops the simulator first, so that its last packets still arrive. @throws RunStopped on bad
  /// ends
  /// @param nothing_under_way  as at the end of lockstep: casd ends at the same time
  void stop(bool nothing_under_way = false);

  /// A fault: casd is gone at once.
  void kill_casd();
  void start_casd();

 private:
  void launch_emulator(const VehiclePlaces& places);
  void launch_hilsim(bool paused);
  /// @throws base::ConfigError when casd cannot open the link for a ground station
  void refuse_closed_station() const;
  ChildProcess::Options options(const std::string& name, const std::string& program,
                                const std::filesystem::path& config,
                                const std::vector<std::string>& further) const;

  Supervisor& supervisor_;
  const RunPlaces& places_;
  const RunRequest& request_;
  std::vector<ChildProcess*> emulators_;
  ChildProcess* casd_ = nullptr;
  ChildProcess* hilsim_ = nullptr;
  FlightLogs logs_;
};

}  // namespace cas::hils
