// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "base/time/clock.hpp"
#include "libsim/api/messages.hpp"
#include "libsim/api/world.hpp"
#include "plugins/common/ulog_file.hpp"

namespace cas::sim {

/// Truth, sensors and actuators of one vehicle as ULog, in N and D and under PX4's topic names, so
/// that the views people have for PX4's own logs fit.
class FlightUlog {
 public:
  FlightUlog() = default;
  /// @param rotors    of the vehicle
  /// @param commands  see command_values(). @throws base::ConfigError
  FlightUlog(const base::ResultPlace& place, int rotors, int commands);

  void write_truth(base::SimTime time, const BodyState& state);
  void write(const ImuSample& sample);
  void write(const GpsSample& sample);
  void write(const MagnetometerSample& sample);
  void write(const BarometerSample& sample);
  void write(const RangeSample& sample);
  void write(const RotorSpeeds& speeds);
  void write(base::SimTime time, const MotorCommand& command);
  void close() { file_.close(); }

 private:
  int commands_ = 0;
  UlogFile file_;
};

}  // namespace cas::sim
