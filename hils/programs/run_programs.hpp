// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "hils/programs/flight_logs.hpp"
#include "hils/programs/supervisor.hpp"
#include "hils/run/run_paths.hpp"
#include "hils/run/run_request.hpp"

namespace cas::hils {

/// hilsim and casd of a run as programs, the same whoever controls.
///
/// A bench adds its controllers, and chooses who starts first: emulators make the PTYs that casd
/// opens, stock firmware looks for its peers.
class RunPrograms {
 public:
  /// All outlive it. @param casd_ledger  casd writes down each HIL packet
  RunPrograms(Supervisor& supervisor, const RunPaths& paths, const RunRequest& request,
              bool casd_ledger);

  /// Starts casd and waits until it is ready; nothing happens where it runs. @throws RunStopped,
  /// base::ConfigError
  void start_casd();
  /// The run's first casd: refuses one that cannot open the link of --gcs, and tells the user how
  /// to watch the run. @throws RunStopped, base::ConfigError
  void start_first_casd();
  /// A fault: casd is gone at once.
  void kill_casd();
  /// Launches hilsim, which the caller waits for. @param further  arguments
  ChildProcess& launch_hilsim(const std::vector<std::string>& further = {});

  ChildProcess* casd() const { return casd_; }
  ChildProcess* hilsim() const { return hilsim_; }
  /// All have ended: the log of the flight becomes one again. @throws base::ConfigError
  void join_logs() { logs_.join(); }

  /// Where a program of the run writes, and says that it is ready. @param arguments  its program
  /// first
  ChildProcess::Options options(const std::string& name, std::vector<std::string> arguments) const;

 private:
  void refuse_closed_station() const;

  Supervisor& supervisor_;
  const RunPaths& paths_;
  const RunRequest& request_;
  bool casd_ledger_;
  ChildProcess* casd_ = nullptr;
  ChildProcess* hilsim_ = nullptr;
  FlightLogs logs_;
};

}  // namespace cas::hils
