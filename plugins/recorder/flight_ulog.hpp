// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>

#include "base/time/clock.hpp"
#include "libsim/api/messages.hpp"
#include "libsim/api/world.hpp"
#include "plugins/common/ulog_file.hpp"
#include "plugins/recorder/flight_csv.hpp"

namespace cas::sim {

/// Truth, sensors and actuators of one vehicle as ULog, in N and D and under PX4's topic names, so
/// that the views people have for PX4's own logs fit.
class FlightUlog {
 public:
  FlightUlog() = default;
  /// @param rotors    of the vehicle
  /// @param commands  see command_values()
  /// @param has_airspeed  the vehicle has a pitot tube
  /// @param surfaces  of a vehicle with a wing. @throws base::ConfigError
  FlightUlog(const base::ResultPlace& place, int rotors, int commands, bool has_airspeed,
             std::optional<int> surfaces);

  /// @param airspeed_m_s  of a vehicle with a pitot tube @param wing  of one with a wing
  void write_truth(base::SimTime time, const BodyState& state, std::optional<double> airspeed_m_s,
                   const std::optional<WingTruth>& wing);
  void write(const ImuSample& sample);
  void write(const GpsSample& sample);
  void write(const MagnetometerSample& sample);
  void write(const BarometerSample& sample);
  void write(const RangeSample& sample);
  void write(const AirspeedSample& sample);
  void write(const RotorSpeeds& speeds);
  void write(base::SimTime time, const MotorCommand& command);
  void close() { file_.close(); }

 private:
  int commands_ = 0;
  UlogFile file_;
};

}  // namespace cas::sim
