// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "hils/programs/supervisor.hpp"
#include "hils/run/run_paths.hpp"
#include "hils/run/run_request.hpp"

namespace cas::hils {

/// The flight logs of a run in which casd is killed and started again: each casd writes a new file
/// of the same name, and in the end they are joined.
class FlightLogs {
 public:
  /// @param log  that casd writes
  /// @param folder  where those of ended casds wait
  FlightLogs(std::filesystem::path log, std::filesystem::path folder)
      : log_(std::move(log)), folder_(std::move(folder)) {}

  /// To be called after casd has been killed: keeps its log from being overwritten.
  void set_aside();
  /// To be called after the last casd has ended.
  /// @throws base::ConfigError when a log cannot be read or written
  void join();

 private:
  std::filesystem::path log_;
  std::filesystem::path folder_;
  std::vector<std::filesystem::path> earlier_;
};

/// hilsim and casd of a run as programs, the same for every controller.
///
/// A bench adds its controllers and chooses the order of starts: emulators make the PTYs that casd
/// opens, while stock firmware needs its peers to listen.
class RunPrograms {
 public:
  struct Records {
    bool casd_ledger = false;  ///< casd keeps its ledger of HIL packets
  };

  /// The references must outlive this object.
  RunPrograms(Supervisor& supervisor, const RunPaths& paths, const RunRequest& request,
              Records records);

  /// Starts casd, unless it runs, and waits until it is ready.
  /// @throws RunStopped, base::ConfigError
  void start_casd();
  /// Starts the run's first casd, and prints how to watch the run.
  /// @throws RunStopped, base::ConfigError, also if casd cannot open the link of --gcs
  void start_first_casd();
  /// Kills casd at once, as a fault of the scenario.
  void kill_casd();
  /// Launches hilsim; the caller waits until it is ready. @param further  arguments
  ChildProcess& launch_hilsim(const std::vector<std::string>& further = {});

  /// nullptr while it does not run.
  ChildProcess* casd() const { return casd_; }
  ChildProcess* hilsim() const { return hilsim_; }
  /// Joins the logs of the flight into one. To be called after all programs have ended.
  /// @throws base::ConfigError
  void join_logs() { logs_.join(); }

  /// Options of a program of the run: its log file and the socket on which it says that it is
  /// ready.
  /// @param arguments  the program first
  ChildProcess::Options options(const std::string& name, std::vector<std::string> arguments) const;

 private:
  void refuse_closed_station() const;

  Supervisor& supervisor_;
  const RunPaths& paths_;
  const RunRequest& request_;
  Records records_;
  ChildProcess* casd_ = nullptr;
  ChildProcess* hilsim_ = nullptr;
  FlightLogs logs_;
};

}  // namespace cas::hils
