// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#include "base/config/vehicle.hpp"
#include "libsim/api/messages.hpp"
#include "libsim/api/world.hpp"
#include "mavlink/common/battery_status.hpp"
#include "mavlink/common/distance_sensor.hpp"
#include "mavlink/common/esc_info.hpp"
#include "mavlink/common/esc_status.hpp"
#include "mavlink/common/heartbeat.hpp"
#include "mavlink/common/hil_actuator_controls.hpp"
#include "mavlink/common/hil_controls.hpp"
#include "mavlink/common/hil_gps.hpp"
#include "mavlink/common/hil_sensor.hpp"
#include "mavlink/common/hil_state_quaternion.hpp"

/// Between the units and frames of the simulation and those of the wire.
namespace cas::sim {

// Fields of floats carry NaN as it is, and flight controllers leave such a reading out. A field of
// whole numbers has the value for unknown, or 0 where there is none.

/// Groups of HIL_SENSOR.fields_updated. A flight controller takes a group only with all its bits.
inline constexpr std::uint32_t kUpdatedAccel = 0x0007;
inline constexpr std::uint32_t kUpdatedGyro = 0x0038;
inline constexpr std::uint32_t kUpdatedMag = 0x01C0;
inline constexpr std::uint32_t kUpdatedBaro = 0x1A00;  // pressure, pressure altitude, temperature
inline constexpr std::uint32_t kUpdatedDiffPressure = 0x0400;

/// Stamp and inertial fields (m/s^2, rad/s in D), flagged as updated.
void fill(mavlink::common::HilSensor& packet, const ImuSample& sample);
/// Magnetic fields (gauss in D), flagged as updated.
void fill(mavlink::common::HilSensor& packet, const MagnetometerSample& sample);
/// Pressure (hPa), pressure altitude (m) and temperature (deg C), flagged as updated.
void fill(mavlink::common::HilSensor& packet, const BarometerSample& sample);

/// Differential pressure (hPa), flagged as updated.
void fill(mavlink::common::HilSensor& packet, const AirspeedSample& sample);

/// Degrees * 1e7, mm, cm/s, cm (eph, epv: as PX4 reads them, [HILS] has no such fields),
/// centidegrees. Without a fix, place and velocity are zero and speed and course unknown (65535). A
/// place or velocity that is not finite is no fix.
mavlink::common::HilGps to_hil_gps(const GpsSample& sample);

/// Centimetres; a reading without a surface, or one that is not a number, says so by its quality.
mavlink::common::DistanceSensor to_distance_sensor(const RangeSample& sample);

/// Battery 0, with its whole voltage instead of those of its cells: mV, cA, mAh, per cent.
mavlink::common::BatteryStatus to_battery_status(const BatterySample& sample);

/// Motors a message of speed controllers has room for.
inline constexpr int kEscsInAMessage = 4;
/// Telemetry of the motors from `first` on (0, 4, ...): revolutions per minute, V, A.
mavlink::common::EscStatus to_esc_status(const EscSample& sample, int first);
/// All of them answer and none reports a failure. @param counter  samples so far
mavlink::common::EscInfo to_esc_info(const EscSample& sample, int first, std::uint16_t counter);

/// True motion of the centre of gravity: attitude of D in N (w, x, y, z), rates in D (rad/s),
/// position in 1e-7 degrees and mm above mean sea level, velocity in cm/s in N. Airspeeds, cm/s:
/// norm of the velocity through the air, and its indicated value in the standard atmosphere at sea
/// level. Acceleration in D, mG of standard gravity: zero at rest, unlike an accelerometer.
mavlink::common::HilStateQuaternion to_hil_state(base::SimTime time, const BodyState& body,
                                                 const Environment& air,
                                                 const base::LocalProjection& projection);

/// The simulator's own HEARTBEAT: a generic system without autopilot.
mavlink::common::Heartbeat simulator_heartbeat();

/// U1..U4 from throttle, roll, pitch and yaw with the vehicle's full scales; armed by mode bit 128.
/// Fields are held to their ranges; NaN counts as 0.
MotorCommand to_motor_command(const mavlink::common::HilControls& packet,
                              const base::ControlScales& scales);
/// Outputs 1..16 from controls[0..15], held to -1..1; armed by mode bit 128.
MotorCommand to_motor_command(const mavlink::common::HilActuatorControls& packet);

}  // namespace cas::sim
