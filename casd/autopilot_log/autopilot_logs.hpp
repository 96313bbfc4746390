// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "casd/autopilot_log/log_files.hpp"
#include "casd/autopilot_log/log_pull.hpp"
#include "casd/packet/link_id.hpp"
#include "casd/packet/packet_info.hpp"
#include "casd/station/vehicle_commander.hpp"
#include "casd/tlog/armed_window.hpp"
#include "casd/tlog/autopilot_log_config.hpp"

namespace cas::casd {

/// One vehicle's log: its file, and why it has none or lacks something.
struct AutopilotLogStatus {
  std::uint8_t system = 0;
  bool wanted = false;  ///< the vehicle is asked for it
  std::optional<LogFilesStatus::Entry> file;
  std::string trouble;  ///< the newest while it is wanted, "does not send ..."; empty: none
};
/// The logs of all vehicles, and their files together, for the command port.
struct AutopilotLogsStatus {
  LogFilesStatus files;
  std::vector<AutopilotLogStatus> vehicles;
};

/// The logs of all vehicles: which vehicle is asked for its log, and when. Only packets of the
/// vehicle itself, from its place, reach its file. On the thread of the commander.
class AutopilotLogs {
 public:
  /// Logs at one time; further vehicles are not asked. A link with many vehicles gives up one for a
  /// vehicle of a link with few: a flood of invented ids must not keep others out.
  static constexpr std::size_t kMostLogs = 16;

  /// All outlive it.
  AutopilotLogs(const AutopilotLogConfig& config, mav::Source self, VehicleCommander& commander,
                LogFiles& files)
      : while_armed_(config.while_armed),
        systems_(config.systems),
        self_(self),
        commander_(commander),
        files_(files) {}

  void on_packet(const Origin& from, const mav::PacketView& packet, base::RunTime now);
  /// Several times a second.
  void tick(base::RunTime now);
  /// Asks all vehicles to end their logs.
  void end(base::RunTime now);
  /// @param now  by the steady clock, also in lockstep
  AutopilotLogsStatus status(base::RunTime now) const;

 private:
  struct Log {
    mav::Source source;
    base::RunTime restarted_at{};
    ArmedWindow window;
    std::optional<LogFiles::File> file;
    bool wanted = false;
    std::string trouble;
    std::unique_ptr<LogPull> pull;
  };

  Log* log_of(const VehicleState& vehicle, base::RunTime now);
  bool is_wanted(std::uint8_t system) const;
  bool make_room(LinkId link, base::RunTime now);
  void tick(Log& log, const VehicleState& vehicle, base::RunTime now);
  LogPullHooks hooks(std::uint8_t system, Log& log);
  void forget_lost(base::RunTime now);

  bool while_armed_;
  std::vector<std::uint8_t> systems_;  ///< empty: all
  mav::Source self_;
  VehicleCommander& commander_;
  LogFiles& files_;
  base::RunTime now_{};
  bool full_ = false;  ///< a vehicle was not asked, and the log says so
  std::map<std::uint8_t, std::unique_ptr<Log>> logs_;  ///< by system
};

}  // namespace cas::casd
