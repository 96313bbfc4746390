// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "base/rpc/client.hpp"
#include "hils/flight/bench_fault.hpp"
#include "hils/measure/run_record.hpp"
#include "hils/programs/bench_programs.hpp"
#include "hils/programs/casd_calls.hpp"
#include "hils/programs/composition.hpp"
#include "hils/programs/cpu_pressure.hpp"
#include "hils/programs/ground_station_thread.hpp"
#include "hils/programs/progress.hpp"
#include "hils/programs/supervisor.hpp"
#include "hils/scenario/fleet_plan.hpp"

namespace cas::hils {

/// Flies the vehicles of a scenario in real time over the control connections of simulator and
/// casd, and plays the faults of the bench.
class RealtimePilot {
 public:
  /// @param ground_station  nothing where the run has none
  RealtimePilot(Supervisor& supervisor, BenchPrograms& programs, const RunPlaces& places,
                const RunRequest& request, GroundStationThread* ground_station);

  /// To the end of the plan, or until it fails. @throws RunStopped, base::rpc::ConnectionError
  /// @param records  of the vehicles, which it fills in
  void fly(std::vector<RunRecord>& records);

 private:
  base::SimTime simulated_time();
  void look();
  std::string give(const FleetPlan::Command& command);
  void show(base::SimTime now);
  void tell_phase();
  void play_faults(base::SimTime now);
  void play(const BenchFault& fault, bool begins);
  void fill(std::vector<RunRecord>& records, const ClockMap& log_clock);
  void watch_machine();
  void watch_stream();

  Supervisor& supervisor_;
  BenchPrograms& programs_;
  const RunPlaces& places_;
  GroundStationThread* ground_station_;
  base::rpc::Client simulator_;
  std::optional<base::rpc::Client> casd_;  ///< nothing while casd is away
  fcu::LineConfig line_;                   ///< as it is without faults
  std::vector<AskedVehicle> asked_;        ///< how casd is to name each vehicle
  FleetPlan plan_;
  BenchFaultScript faults_;
  Progress progress_;
  CpuPressure pressure_;
  std::string phase_;
  std::string stream_;  ///< rates and drops in words, for the terminal
  base::RunTime next_stream_look_{};
  bool measuring_ = false;
  double real_time_factor_ = 0;
  std::vector<VehicleReport> vehicles_;
  std::vector<Eigen::Vector3d> start_m_;  ///< where they stood when the run began
};

}  // namespace cas::hils
