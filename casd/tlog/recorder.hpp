// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "base/time/clock.hpp"
#include "casd/tlog/armed_window.hpp"
#include "casd/tlog/autopilot_log_config.hpp"
#include "casd/tlog/tlog_writer.hpp"

namespace cas::casd {

/// Logs, as the topology has them (`log`).
struct TlogConfig {
  std::filesystem::path folder{};  ///< empty: the working folder
  std::string tlog{};              ///< name of the recording from the start; empty: none
  TlogRotation rotation{};
  LogLimits keep{};  ///< of the telemetry logs, and of the autopilots' logs
  std::optional<AutopilotLogConfig> autopilot{};  ///< nullopt: no log is taken from an autopilot
  bool while_armed = false;  ///< not from the start, but while any vehicle is armed
  bool overwrite = false;    ///< replaces NAME.tlog; false: each recording has its own dated name

  friend bool operator==(const TlogConfig&, const TlogConfig&) = default;
};

/// Begins and ends recordings: from casd's start, on request, or while a vehicle is armed. On one
/// thread.
class Recorder {
 public:
  /// `writer` outlives it.
  Recorder(TlogWriter& writer, TlogConfig config);

  /// Begins the recording that the configuration wants from the start, or stands by for flights.
  /// @throws base::ConfigError
  void begin();
  /// Begins a recording and ends the one under way. Does not wait for the disk.
  /// @param name  empty: its date alone. @throws base::ConfigError when it is no name for a file
  void start(const std::string& name, const TlogRotation& rotation, TlogWriter::Done done);
  /// Ends the recording; with `while_armed` the next arming begins another one. Does not wait for
  /// the disk.
  void stop(TlogWriter::Done done);
  /// The same, and waits until the disk has it.
  void stop();
  /// Says whether a vehicle is armed: to be called at each change, and several times a second. Does
  /// not wait for the disk.
  void on_vehicles(bool any_armed, base::RunTime now);

  /// Whether a recording is ordered, and its end is not.
  bool records() const { return writer_.active(); }
  TlogStatus status(base::RunTime now) const { return writer_.status(now); }
  /// Whether the next arming begins a recording.
  bool awaits_arming() const { return config_.while_armed && !writer_.active(); }
  const TlogConfig& config() const { return config_; }

 private:
  TlogRecording::Options options(const std::string& name, const TlogRotation& rotation) const;

  TlogWriter& writer_;
  TlogConfig config_;
  ArmedWindow window_;
  bool flying_ = false;     ///< whether the window was open
  bool of_flight_ = false;  ///< the recording under way ends with the window
};

}  // namespace cas::casd
