// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
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
  /// Offset of the first byte; zeros fill a gap before it. nullopt: the end of the file.
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

/// Asks a vehicle for the log that it is writing, and receives it. Decides when to ask and when to
/// begin and end a file; the subclass of each autopilot knows the messages and joins the bytes.
/// Pure.
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

  explicit LogPull(LogPullHooks hooks) : hooks_(std::move(hooks)) {}
  virtual ~LogPull() = default;

  /// A packet of this vehicle, from its place, for casd's own station.
  void on_packet(const mav::PacketView& packet, base::RunTime now);
  /// Called while the log is wanted: sends requests and repeats them.
  void tick(base::RunTime now);
  /// Asks the vehicle to end its log, and closes the file. The next tick() begins again.
  void stop(base::RunTime now);
  /// The vehicle has restarted and forgotten all requests: closes the file.
  void restart(base::RunTime now);

 protected:
  /// Begins a new file. @return false less than kFilePeriod after the last one
  bool begin_file(std::string_view extension);
  /// A silence counts from now: the vehicle has accepted a request.
  void await_data() { heard_at_ = now_; }
  /// Data has come: the next request is a first one.
  void hear();
  bool is_silent() const { return now_ - heard_at_ > kSilence; }
  /// Doubles the wait for the next request each time, until data comes.
  void ask_later(base::Duration at_least, base::Duration longest);
  /// Writes bytes, if there are any. When the queue to the disk is full, the log ends, and goes on
  /// in another file: readers do not see a gap without a mark.
  void write(LogPart part);

  LogPullHooks hooks_;
  base::RunTime now_{};       ///< of the newest call
  base::RunTime next_ask_{};  ///< the vehicle is not asked earlier
  base::Duration retry_ = kFirstRetry;

 private:
  virtual void take(const mav::PacketView& packet) = 0;
  virtual void ask() = 0;         ///< for the log, if it is time
  virtual void ask_to_end() = 0;  ///< if the vehicle may be sending
  virtual void forget() = 0;      ///< clears received data and requests

  bool wanted_ = false;
  base::RunTime next_file_{};
  base::RunTime heard_at_{};
};

}  // namespace cas::casd
