// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "base/config/config.hpp"
#include "base/config/vehicle.hpp"
#include "libsim/api/messages.hpp"
#include "mavlink/common/servo_output_raw.hpp"

namespace cas::sim {

/// Pulses of an output, us: ArduPilot's SERVOn_MIN, SERVOn_TRIM and SERVOn_MAX.
struct ServoRange {
  double min_us = 1000;
  double trim_us = 1500;
  double max_us = 2000;
};

/// What SERVO_OUTPUT_RAW means for a vehicle: the pulses of its rotors and servos as outputs. A
/// rotor's is its place between min and max, 0..1; a servo's its place about trim, -1..1. A pulse
/// of 0 us is no output: 0.
class ServoMap {
 public:
  /// @param node  key `servo_outputs` of the plugin: min_us, trim_us and max_us of all outputs, and
  ///     under `channels` those of single ones: {5: {min_us: 1100}}
  /// @throws base::ConfigError
  ServoMap(const base::ConfigNode& node, const base::Vehicle& vehicle);

  /// Armed is a rotor above its min: an armed ArduPilot idles there. Outputs 9 to 16 are those of
  /// MAVLink 2.
  MotorCommand to_motor_command(const mavlink::common::ServoOutputRaw& packet) const;

 private:
  struct Output {
    int number = 0;  ///< from 0
    bool is_rotor = false;
    ServoRange range;
  };

  std::vector<Output> outputs_;
};

}  // namespace cas::sim
