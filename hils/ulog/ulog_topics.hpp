// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string_view>
#include <vector>

#include "plugins/common/ulog_file.hpp"

namespace cas::hils {

/// Topics of a run's ULog, by message id. Names and fields are PX4's, so that the views people have
/// for its logs fit; a field that no run has a value for is left out. docs/reference/config.md has
/// the table.
enum class UlogTopicId : std::uint16_t {
  // The controller's own word.
  kAttitude,
  kAngularVelocity,
  kLocalPosition,
  kGlobalPosition,
  kAttitudeSetpoint,
  kRatesSetpoint,
  kLocalPositionSetpoint,
  kTrajectorySetpoint,
  kTorqueSetpoint,
  kThrustSetpoint,
  kActuatorMotors,
  kActuatorOutputs,
  kVehicleStatus,
  kLandDetected,
  kBattery,
  // Samples of the simulated sensors.
  kSensorCombined,
  kGpsPosition,
  kMagnetometer,
  kAirData,
  kDistance,
  // The truth.
  kAttitudeTruth,
  kAngularVelocityTruth,
  kLocalPositionTruth,
  kGlobalPositionTruth,
  kRotorSpeeds,
  // Vehicles with a pitot tube.
  kAirspeedTruth,
  kDifferentialPressure,
  // Vehicles with a wing.
  kWingTruth,
};

/// Definitions of all of them, in the order of UlogTopicId, for a vehicle of 1 to 16 rotors.
/// @param has_airspeed  a pitot tube: without one its two have no fields
/// @param wing_fields   those of the truth of a wing; empty: it has none
std::vector<sim::UlogTopic> ulog_topics(int rotors, bool has_airspeed,
                                        std::string_view wing_fields = {});

/// Writes a message of a topic.
inline void write(sim::UlogFile& file, UlogTopicId topic, const sim::UlogRecord& record) {
  file.write(static_cast<std::uint16_t>(topic), record);
}

}  // namespace cas::hils
