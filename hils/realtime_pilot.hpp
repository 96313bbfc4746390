// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "base/rpc/client.hpp"
#include "hils/bench_fault.hpp"
#include "hils/bench_programs.hpp"
#include "hils/composition.hpp"
#include "hils/cpu_pressure.hpp"
#include "hils/flight_plan.hpp"
#include "hils/ground_station_thread.hpp"
#include "hils/measurement.hpp"
#include "hils/progress.hpp"
#include "hils/supervisor.hpp"

namespace cas::hils {

/// Flies a plan in real time over the control connections of simulator and casd, and plays the
/// faults of the bench.
class RealtimePilot {
 public:
  /// @param ground_station  nothing where the run has none
  RealtimePilot(Supervisor& supervisor, BenchPrograms& programs, const RunPlaces& places,
                const RunRequest& request, GroundStationThread* ground_station);

  /// To the end of the plan, or until it fails. @throws RunStopped, base::rpc::ConnectionError
  void fly(RunRecord& record);

 private:
  base::SimTime simulated_time();
  VehicleReport look();
  std::string give(const FlightStep& step);
  void tell_phase();
  void play_faults(base::SimTime now, const VehicleReport& vehicle);
  void play(const BenchFault& fault, bool begins);
  void configure_line(const fcu::LineConfig& line);
  void watch_machine();
  void watch_stream();

  Supervisor& supervisor_;
  BenchPrograms& programs_;
  const RunPlaces& places_;
  GroundStationThread* ground_station_;
  base::rpc::Client simulator_;
  std::optional<base::rpc::Client> casd_;  ///< nothing while casd is away
  fcu::LineConfig line_;                   ///< as it is without faults
  FlightPlan plan_;
  BenchFaultScript faults_;
  Progress progress_;
  CpuPressure pressure_;
  std::string phase_;
  std::string stream_;  ///< rates and drops in words, for the terminal
  base::RunTime next_stream_look_{};
  bool measuring_ = false;
  double real_time_factor_ = 0;
  std::optional<Motion> truth_;
  std::optional<Eigen::Vector3d> start_m_;
};

}  // namespace cas::hils
