// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <cstdint>
#include <optional>
#include <string_view>

#include "base/config/vehicle.hpp"
#include "base/earth/geodesy.hpp"
#include "base/time/clock.hpp"

/// Messages on the topic bus. Each type declares its name and version: a topic is refused when
/// publisher and subscriber were built against different declarations.
namespace cas::sim {

/// Outputs of an autopilot or its substitute; no heap.
using ActuatorValues =
    Eigen::Matrix<double, Eigen::Dynamic, 1, Eigen::ColMajor, base::kMaxOutputs, 1>;

/// Sets the rotors. Exactly one of the two forms, chosen by `kind`.
struct MotorCommand {
  static constexpr std::string_view kTypeName = "cas.MotorCommand";
  static constexpr unsigned kTypeVersion = 2;
  enum class Kind : std::uint8_t {
    kControlInputs,  ///< values = U1 (N), U2, U3, U4 (N m) in the axes of D, [HILS] Eq. (3)
    kMotorOutputs,   ///< values = outputs 1..16 of the autopilot: rotors 0..1, servos -1..1
  };
  /// Time of the HIL_SENSOR it was computed from, as far as the sender says.
  base::SimTime sensor_time;
  Kind kind = Kind::kControlInputs;
  bool armed = false;  ///< disarmed, the rotors stop whatever `values` says
  ActuatorValues values = ActuatorValues::Zero(4);
};

/// Rotor speeds after the step, rad/s, non-negative; rotor n of the vehicle file at n - 1.
struct RotorSpeeds {
  static constexpr std::string_view kTypeName = "cas.RotorSpeeds";
  static constexpr unsigned kTypeVersion = 2;
  base::SimTime time;
  base::RotorVector omega_rad_s = base::RotorVector::Zero(4);
};

/// Deflections of the control surfaces after the step, rad, in the order of the vehicle file.
struct SurfaceDeflections {
  static constexpr std::string_view kTypeName = "cas.SurfaceDeflections";
  static constexpr unsigned kTypeVersion = 1;
  base::SimTime time;
  ActuatorValues angle_rad = ActuatorValues::Zero(0);
};

/// Specific force and angular rate at the sensor, in B. Level and at rest: (0, 0, +g).
struct ImuSample {
  static constexpr std::string_view kTypeName = "cas.ImuSample";
  static constexpr unsigned kTypeVersion = 1;
  base::SimTime time;
  Eigen::Vector3d specific_force_B = Eigen::Vector3d::Zero();  ///< m/s^2
  Eigen::Vector3d angular_rate_B = Eigen::Vector3d::Zero();    ///< rad/s
  /// True attitude: the orientation that [HILS] Sect. 3.1 names. Not sent in HIL_SENSOR.
  Eigen::Quaterniond q_WB = Eigen::Quaterniond::Identity();
};

/// A fix of the receiver.
struct GpsSample {
  static constexpr std::string_view kTypeName = "cas.GpsSample";
  static constexpr unsigned kTypeVersion = 2;
  base::SimTime time;            ///< of measurement, before the receiver's delay
  std::uint8_t fix_type = 3;     ///< GPS_FIX_TYPE
  std::uint8_t satellites = 10;  ///< used in the fix
  base::Geodetic position;       ///< degrees, m above mean sea level
  Eigen::Vector3d velocity_N = Eigen::Vector3d::Zero();  ///< north, east, down, m/s
  double eph_m = 0;                                      ///< horizontal accuracy claimed, 1 sigma
  double epv_m = 0;                                      ///< vertical accuracy claimed, 1 sigma
  double cn0_db_hz = 44;  ///< carrier to noise density, mean of the satellites in view; open sky
};

/// Magnetic field at the sensor, in B, gauss.
struct MagnetometerSample {
  static constexpr std::string_view kTypeName = "cas.MagnetometerSample";
  static constexpr unsigned kTypeVersion = 1;
  base::SimTime time;
  Eigen::Vector3d field_B_gauss = Eigen::Vector3d::Zero();
};

/// Static pressure and temperature at the sensor.
struct BarometerSample {
  static constexpr std::string_view kTypeName = "cas.BarometerSample";
  static constexpr unsigned kTypeVersion = 1;
  base::SimTime time;
  double pressure_pa = 0;
  double temperature_degc = 0;
};

/// Pressure in a pitot tube above the static pressure.
struct AirspeedSample {
  static constexpr std::string_view kTypeName = "cas.AirspeedSample";
  static constexpr unsigned kTypeVersion = 1;
  base::SimTime time;
  double differential_pressure_pa = 0;
};

/// Distance of the nearest surface in the beam of a rangefinder, and the limits of its range.
struct RangeSample {
  static constexpr std::string_view kTypeName = "cas.RangeSample";
  static constexpr unsigned kTypeVersion = 4;
  base::SimTime time;
  double distance_m = 0;
  double min_m = 0;
  double max_m = 0;
  bool valid = false;                     ///< something was met between min_m and max_m
  Eigen::Vector3d direction_B{0, 0, -1};  ///< of the beam, unit
  double beam_rad = 0;                    ///< width of its cone; 0: a ray
};

/// Flow of the ground in a camera, its own turn and the time since the sample before.
struct FlowSample {
  static constexpr std::string_view kTypeName = "cas.FlowSample";
  static constexpr unsigned kTypeVersion = 1;
  base::SimTime time;
  double time_s = 0;
  Eigen::Vector2d flow_rad = Eigen::Vector2d::Zero();  ///< about the axes of D
  Eigen::Vector3d turn_rad = Eigen::Vector3d::Zero();  ///< of the camera, axes of D
  std::uint8_t quality = 0;                            ///< 255: followed all the time; 0: never
  std::optional<double> distance_m;                    ///< newest, to the ground along the axis
};

/// A picture of a camera that looks for a beacon to land by.
struct LandingTargetSample {
  static constexpr std::string_view kTypeName = "cas.LandingTargetSample";
  static constexpr unsigned kTypeVersion = 1;
  base::SimTime time;  ///< when it was taken
  bool seen = false;   ///< the beacon is in it
  /// Angles of the beacon from the middle of the picture: to the right, and to the back.
  Eigen::Vector2d angles_rad = Eigen::Vector2d::Zero();
  std::optional<double> distance_m;  ///< nullopt: not measured
};

/// A battery as a power module measures it.
struct BatterySample {
  static constexpr std::string_view kTypeName = "cas.BatterySample";
  static constexpr unsigned kTypeVersion = 1;
  base::SimTime time;
  double voltage_v = 0;  ///< at its terminals
  double current_a = 0;
  double used_ah = 0;  ///< since it was full
  double charge = 1;   ///< 1 full, 0 empty
};

/// Telemetry of the motors' speed controllers, rotor n of the vehicle file at n - 1.
struct EscSample {
  static constexpr std::string_view kTypeName = "cas.EscSample";
  static constexpr unsigned kTypeVersion = 1;
  base::SimTime time;
  base::RotorVector omega_rad_s = base::RotorVector::Zero(4);
  base::RotorVector current_a = base::RotorVector::Zero(4);  ///< of the motors
  double voltage_v = 0;                                      ///< at the battery's terminals
};

/// Asks the wind for a 1-cosine gust from now on.
struct GustCommand {
  static constexpr std::string_view kTypeName = "cas.GustCommand";
  static constexpr unsigned kTypeVersion = 1;
  Eigen::Vector3d amplitude_N_m_s = Eigen::Vector3d::Zero();  ///< air velocity at its height
  double length_m = 0;                                        ///< of air in which it rises
  double hold_s = 0;                                          ///< time at the amplitude
};

/// Remaining shares of rotors and battery; all ones if nothing is broken.
struct PropulsionHealth {
  static constexpr std::string_view kTypeName = "cas.PropulsionHealth";
  static constexpr unsigned kTypeVersion = 4;
  /// Share of the commanded speed, for each rotor that a vehicle may have; 0: stopped.
  base::RotorVector speed_share = base::RotorVector::Ones(base::kMaxRotors);
  /// Share of thrust and torque at a speed; below 0: the rotor turns the other way.
  base::RotorVector thrust_share = base::RotorVector::Ones(base::kMaxRotors);
  double voltage_share = 1;  ///< of the battery's voltage
  /// Rotors that keep the speed they were last driven to, whatever is asked of them.
  std::array<bool, base::kMaxRotors> stuck{};
  /// Rotors whose motor has no current: its controller has lost the beat.
  std::array<bool, base::kMaxRotors> without_current{};
  /// Index of the command that drives each rotor: its own, unless wires were swapped.
  std::array<std::uint8_t, base::kMaxRotors> wired_as = [] {
    std::array<std::uint8_t, base::kMaxRotors> own{};
    for (std::size_t i = 0; i < own.size(); ++i) own[i] = static_cast<std::uint8_t>(i);
    return own;
  }();
};

/// Whether the line of a sensor unit with one of its own (plugin external_ahrs) is cut: no byte
/// passes, either way.
struct LineCut {
  static constexpr std::string_view kTypeName = "cas.LineCut";
  static constexpr unsigned kTypeVersion = 1;
  bool cut = false;
};

/// Name of the part of the flight that the run is in ("takeoff", "hold"), published by its pilot
/// program.
struct FlightPhase {
  static constexpr std::string_view kTypeName = "cas.FlightPhase";
  static constexpr unsigned kTypeVersion = 1;
  std::array<char, 32> name{};  ///< NUL-terminated
};

/// One packet in wire format, for interfaces that hand packets over inside the process.
struct WirePacket {
  static constexpr std::string_view kTypeName = "cas.WirePacket";
  static constexpr unsigned kTypeVersion = 1;
  std::array<std::uint8_t, 280> bytes{};
  std::size_t size = 0;
};

}  // namespace cas::sim
