// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>

#include "base/time/clock.hpp"
#include "casd/autopilot_log/autopilot_logs.hpp"
#include "casd/autopilot_log/log_files.hpp"
#include "casd/station/failure_injector.hpp"
#include "casd/station/vehicle_commander.hpp"
#include "casd/tlog/recorder.hpp"

namespace cas::casd {

/// casd's own station: failures go to the simulator, logs of autopilots to their files, all else to
/// the commander.
class OwnStation final : public Station {
 public:
  /// @param commander, failures  outlive the station
  OwnStation(VehicleCommander& commander, FailureInjector& failures)
      : commander_(commander), failures_(failures) {}

  /// Takes the logs of autopilots from now on, if the configuration wants them.
  /// @throws base::ConfigError
  void take_logs(const TlogConfig& config, mav::Source self);
  /// Ends the logs under way.
  void end_logs(base::RunTime now);
  /// The logs of autopilots; nullopt: none are taken.
  /// @param now  by the steady clock, also in lockstep
  std::optional<AutopilotLogsStatus> logs(base::RunTime now) const;

  void on_packet(const Origin& from, const mav::PacketView& packet, base::RunTime now) override;
  void tick(base::RunTime now) override;
  /// Gives up on simulators that do not answer.
  /// @param wall  this machine's clock, also in lockstep
  void tick_failures(base::RunTime wall) { failures_.tick(wall); }
  /// In lockstep: ends overdue requests by this machine's clock, also while the simulation is
  /// paused.
  void wall_tick(base::RunTime wall);
  /// When to call tick() next; a packet or a request may make it sooner.
  base::RunTime next_tick(base::RunTime now) const;
  bool any_armed(base::RunTime now) const { return commander_.any_armed(now); }

 private:
  /// The logs of autopilots and the files that they go to.
  struct LogTaking {
    LogTaking(const TlogConfig& config, mav::Source self, VehicleCommander& commander)
        : files(config.folder, config.keep), logs(*config.autopilot, self, commander, files) {}

    LogFiles files;
    AutopilotLogs logs;
  };

  VehicleCommander& commander_;
  FailureInjector& failures_;
  std::optional<LogTaking> log_taking_;
};

}  // namespace cas::casd
