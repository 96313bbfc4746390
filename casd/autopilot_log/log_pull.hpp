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
  /// Place of the first byte; zeros fill what lies before it. Nothing: at the end.
  std::optional<std::uint64_t> at{};
};

/// What the log of one vehicle is taken with.
struct LogPullHooks {
  std::function<void(const VehicleCommander::LogAnswer&)> send;  ///< to the vehicle
  std::function<void(const VehicleCommand&, Done)> command;
  std::function<void(std::string_view extension)> begin;  ///< another file
  /// Nothing without a file. @return false when there is no room for it in memory
  std::function<bool(LogPart)> write;
  std::function<void()> end;  ///< of the file; nothing without one
  std::function<void(const std::string& sentence)> warn;
};

/// Has one vehicle send its log while it is written, and takes it in. Pure.
class LogPull {
 public:
  /// Another file of a vehicle begins no sooner after the last one: files are not to be had for
  /// each packet.
  static constexpr base::Duration kFilePeriod = std::chrono::seconds(5);
  /// After such a silence the vehicle is asked again. An ArduPilot whose blocks nobody acknowledges
  /// ends the log after 10 s.
  static constexpr base::Duration kSilence = std::chrono::seconds(10);
  static constexpr base::Duration kFirstRetry = std::chrono::seconds(1);
  static constexpr base::Duration kLongestRetry = std::chrono::seconds(60);

  virtual ~LogPull() = default;

  /// A packet of this vehicle, from its place, for casd's own station.
  virtual void on_packet(const mav::PacketView& packet, base::RunTime now) = 0;
  /// While the log is wanted: requests, and repeats them.
  virtual void tick(base::RunTime now) = 0;
  /// Has the vehicle end its log, and ends the file. It may be wanted again afterwards.
  virtual void stop(base::RunTime now) = 0;
  /// The vehicle has begun anew and knows of nothing: the file ends.
  virtual void restart(base::RunTime now) = 0;
};

}  // namespace cas::casd
