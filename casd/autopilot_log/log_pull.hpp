// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/time/clock.hpp"
#include "casd/station/vehicle_commander.hpp"
#include "mavlink_gen/runtime/packet.hpp"
#include "mavlink_gen/services/remote_log.hpp"

namespace cas::casd {

using mav::services::RemoteLogBlockStatus;
using mav::services::RemoteLogDataBlock;

/// Bytes on their way into a log file.
struct LogPart {
  std::vector<std::uint8_t> bytes;
  /// Offset of the first byte; zeros fill a gap before it. Nothing: the end of the file.
  std::optional<std::uint64_t> at{};
};

/// The vehicle and the file of a LogPull.
struct LogPullHooks {
  std::function<void(const VehicleCommander::LogAnswer&)> send;  ///< to the vehicle
  std::function<void(const VehicleCommand&, Done)> command;
  std::function<void(std::string_view extension)> begin;  ///< begins a new file
  /// Writes to the file, if there is one. @return false when the queue to the disk is full
  std::function<bool(LogPart)> write;
  std::function<void()> end;  ///< closes the file, if there is one
  std::function<void(const std::string& sentence)> warn;
};

/// Asks a vehicle for the log that it is writing, and receives it. Pure.
class LogPull {
 public:
  /// Least time between the beginnings of two files of a vehicle: a flood of headers must not
  /// become a flood of files.
  static constexpr base::Duration kFilePeriod = std::chrono::seconds(5);
  /// After this silence the vehicle is asked again. ArduPilot ends a log whose blocks are not
  /// acknowledged for 10 s.
  static constexpr base::Duration kSilence = std::chrono::seconds(10);
  static constexpr base::Duration kFirstRetry = std::chrono::seconds(1);
  static constexpr base::Duration kLongestRetry = std::chrono::seconds(60);

  virtual ~LogPull() = default;

  /// A packet of this vehicle, from its place, for casd's own station.
  virtual void on_packet(const mav::PacketView& packet, base::RunTime now) = 0;
  /// Called while the log is wanted: sends requests and repeats them.
  virtual void tick(base::RunTime now) = 0;
  /// Asks the vehicle to end its log, and closes the file. The next tick() begins again.
  virtual void stop(base::RunTime now) = 0;
  /// The vehicle has restarted and forgotten all requests: closes the file.
  virtual void restart(base::RunTime now) = 0;
};

}  // namespace cas::casd
