// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstdint>
#include <optional>
#include <string_view>

namespace cas::fcu {

/// Flight modes. Names and wire numbers are PX4's.
enum class FlightMode : std::uint8_t {
  kStabilized,  ///< pilot: tilt, yaw rate, thrust
  kAltitude,    ///< pilot: tilt, yaw rate, climb rate
  kPosition,    ///< pilot: velocity, yaw rate; holds when the sticks are centred
  kOffboard,    ///< a companion streams setpoints
  kTakeoff,
  kHold,
  kMission,
  kReturn,
  kLand,
  kTermination,  ///< rotors stopped, for good
};

/// HEARTBEAT.custom_mode: main mode in bits 16-23, sub mode in bits 24-31.
std::uint32_t px4_custom_mode(FlightMode mode);
/// The same the other way round; nullopt where this controller has no such mode. Of the main modes
/// but AUTO the sub mode does not count.
std::optional<FlightMode> flight_mode_from_custom(std::uint32_t custom_mode);
/// "HOLD", "TAKEOFF" ...
std::string_view name(FlightMode mode);

/// Flown by sticks.
bool is_manual(FlightMode mode);
/// Needs a horizontal position estimate.
bool needs_position(FlightMode mode);

enum class LandedState : std::uint8_t { kOnGround, kTakingOff, kInAir, kLanding };

/// Estimate, references and state of the controller at its last step.
struct FlightStatus {
  bool armed = false;
  bool estimator_ready = false;
  FlightMode mode = FlightMode::kHold;
  LandedState landed = LandedState::kOnGround;
  bool on_wing = false;   ///< a plane, or a VTOL after its transition
  std::string_view vtol;  ///< "multicopter", "to_plane", "plane", "to_multicopter"; empty: no VTOL
  std::uint64_t sensor_time_usec = 0;                           ///< stamp of the newest HIL_SENSOR
  Eigen::Quaterniond q_ND = Eigen::Quaterniond::Identity();     ///< estimated attitude
  Eigen::Vector3d p_N = Eigen::Vector3d::Zero();                ///< estimated position, m
  Eigen::Vector3d v_N = Eigen::Vector3d::Zero();                ///< estimated velocity, m/s
  Eigen::Vector3d w_D = Eigen::Vector3d::Zero();                ///< estimated body rates, rad/s
  Eigen::Vector3d position_stddev_m = Eigen::Vector3d::Zero();  ///< the estimator's own opinion
  Eigen::Vector3d reference_N =
      Eigen::Vector3d::Zero();  ///< position reference, m (hold: NaN if none)
  double yaw_reference_rad = 0;
  Eigen::Vector4d u = Eigen::Vector4d::Zero();  ///< U1 (N), U2, U3, U4 (N m) as sent
};

}  // namespace cas::fcu
