// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include "base/config/config.hpp"
#include "base/earth/geodesy.hpp"
#include "base/export.hpp"

/// The data sheet of each sensor: one block of a sensor set (sensor_set.hpp), in the units of its
/// keys. The sensor's plugin simulates by it and the controller's estimator assumes it, so both
/// read it here.
namespace cas::base {

/// White noise by axis: one of the two.
struct WhiteNoise {
  std::optional<Eigen::Vector3d> stddev;   ///< of one sample
  std::optional<Eigen::Vector3d> density;  ///< per square root of a hertz

  const Eigen::Vector3d& figure() const { return stddev ? *stddev : *density; }
  /// The deviation of one sample is figure() times this.
  double per_sample(double rate_hz) const { return stddev ? 1.0 : std::sqrt(rate_hz); }
};

/// Slow drift by axis: a walk, a standing deviation, or none.
struct Drift {
  std::optional<Eigen::Vector3d> bias_walk;  ///< per square root of a second
  double bias_time_constant_s = 0;           ///< 0: a pure random walk
  std::optional<Eigen::Vector3d> stddev;     ///< standing
  double time_constant_s = 0;
};

/// Errors of a gyroscope (deg/s) or an accelerometer (m/s^2). Zero: none.
struct TriadSheet {
  WhiteNoise noise;
  Eigen::Vector3d bias = Eigen::Vector3d::Zero();
  Eigen::Vector3d turn_on_bias_stddev = Eigen::Vector3d::Zero();
  Drift drift;
  Eigen::Vector3d scale_error = Eigen::Vector3d::Zero();  ///< fraction
  Eigen::Vector3d misalignment_deg = Eigen::Vector3d::Zero();
  double range = 0;
  double lsb = 0;
  Eigen::Vector3d vibration = Eigen::Vector3d::Zero();
  Eigen::Vector3d temperature = Eigen::Vector3d::Zero();          ///< bias per degree
  Eigen::Vector3d temperature_squared = Eigen::Vector3d::Zero();  ///< and per its square
};

/// Data sheet of an IMU: keys of plugin imu.
struct ImuSheet {
  double rate_hz = 0;
  TriadSheet gyro;
  TriadSheet accel;
  Eigen::Vector3d gyro_g_sensitivity_deg_s_per_m_s2 = Eigen::Vector3d::Zero();
  double vibration_reference_rad_s = 0;
  std::vector<double> vibration_harmonics;  ///< of the 2nd, 3rd, ..., fraction of the first
  std::vector<double> vibration_imbalance;  ///< of each rotor, factor
  double warm_up_degc = 0;
  double warm_up_time_constant_s = 0;
  double start_degc = 0;
  Eigen::Vector3d position_B_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d mounting_rpy_deg = Eigen::Vector3d::Zero();
};

/// Data sheet of a GPS receiver: keys of plugin gps.
struct GpsSheet {
  /// A stretch of time without a fix.
  struct FixLoss {
    double from_s = 0;
    double to_s = 0;
  };
  double rate_hz = 0;
  double delay_s = 0;
  WhiteNoise position;  ///< north, east, down, m
  Drift position_drift;
  WhiteNoise velocity;  ///< m/s
  double eph_m = 0;
  double epv_m = 0;
  int satellites = 0;
  double first_fix_s = 0;
  std::vector<FixLoss> fix_losses;
  Eigen::Vector3d antenna_B_m = Eigen::Vector3d::Zero();
  std::optional<EarthModel> earth_model;  ///< nullopt: the world's own projection
};

/// Data sheet of a magnetometer: keys of plugin magnetometer.
struct MagnetometerSheet {
  double rate_hz = 0;
  WhiteNoise noise;  ///< gauss
  Drift drift;
  Eigen::Vector3d hard_iron_gauss = Eigen::Vector3d::Zero();
  Eigen::Matrix3d soft_iron = Eigen::Matrix3d::Identity();
  double lsb_gauss = 0;
};

/// Data sheet of a barometer: keys of plugin barometer.
struct BarometerSheet {
  double rate_hz = 0;
  WhiteNoise noise;  ///< Pa
  Drift drift;
  double self_heating_degc = 0;
  double wind_pressure_coefficient = 0;
  double lsb_pa = 0;
};

/// Data sheet of a rangefinder: keys of plugin rangefinder.
struct RangefinderSheet {
  double rate_hz = 0;
  WhiteNoise noise;  ///< m
  double min_m = 0;
  double max_m = 0;
  double lsb_m = 0;
  Eigen::Vector3d position_B_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d direction_B{0, 0, -1};  ///< unit vector
  double beam_deg = 0;                    ///< width of its cone; 0: a ray
};

/// Format of files of scans: point clouds, and pictures of depth cameras.
enum class CloudForm { kPcd, kPly, kPgm };

/// Data sheet of a lidar: keys of plugin lidar.
struct LidarSheet {
  std::string pattern;  ///< file
  double rate_hz = 0;   ///< scans in a second
  double min_m = 0;
  double max_m = 0;
  double stddev_m = 0;  ///< white, of one distance
  double dropout = 0;   ///< share of lost beams
  double max_incidence_deg = 90;
  Eigen::Vector3d position_B_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d mounting_rpy_deg = Eigen::Vector3d::Zero();
  std::optional<double> obstacle_height_m;  ///< nullopt: no OBSTACLE_DISTANCE
  std::optional<CloudForm> cloud;           ///< nullopt: no files
  int cloud_every = 10;
  std::string cloud_folder = "clouds";
};

/// Data sheet of a pitot tube: keys of plugin airspeed.
struct AirspeedSheet {
  double rate_hz = 0;
  WhiteNoise noise;  ///< Pa
  double bias_pa = 0;
  Drift drift;
  double position_error = 0;  ///< fraction of the dynamic pressure
  double lag_s = 0;
  Eigen::Vector3d position_B_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d direction_B{1, 0, 0};  ///< unit vector
};

/// The message by which odometry goes to the controller.
enum class OdometryMessage { kOdometry, kVisionPositionEstimate };
/// What the axes of its frame are called on the wire: MAV_FRAME_LOCAL_FRD or MAV_FRAME_LOCAL_NED.
enum class OdometryFrame { kLocalFrd, kLocalNed };
/// The kind of estimate that it is called on the wire, with the numbers of MAV_ESTIMATOR_TYPE.
enum class OdometryKind { kUnknown = 0, kNaive = 1, kVision = 2, kVio = 3, kMocap = 6, kLidar = 7 };

/// A visual-inertial unit or a motion capture system. Its frame F has x along its heading, y to the
/// right of it and z down.
struct OdometrySheet {
  double rate_hz = 0;
  double delay_s = 0;
  WhiteNoise position;                                      ///< axes of F, m
  WhiteNoise attitude;                                      ///< about the axes of D, deg
  WhiteNoise velocity;                                      ///< axes of D, m/s
  WhiteNoise rate;                                          ///< axes of D, deg/s
  Eigen::Vector3d position_walk = Eigen::Vector3d::Zero();  ///< m per square root of a second
  double yaw_walk = 0;                                      ///< deg per square root of a second
  Eigen::Vector3d origin_N_m = Eigen::Vector3d::Zero();     ///< of F
  double heading_deg = 0;                                   ///< of F, clockwise from north
  Eigen::Vector3d position_B_m = Eigen::Vector3d::Zero();
  OdometryMessage message = OdometryMessage::kOdometry;
  OdometryFrame frame = OdometryFrame::kLocalFrd;
  OdometryKind estimator_type = OdometryKind::kVio;
  int quality = 100;  ///< %
};

// Each reads one block. @throws ConfigError "FILE:LINE: key.path: sentence"
CAS_BASE_EXPORT ImuSheet read_imu_sheet(const ConfigNode& node);
CAS_BASE_EXPORT GpsSheet read_gps_sheet(const ConfigNode& node);
CAS_BASE_EXPORT MagnetometerSheet read_magnetometer_sheet(const ConfigNode& node);
CAS_BASE_EXPORT BarometerSheet read_barometer_sheet(const ConfigNode& node);
CAS_BASE_EXPORT RangefinderSheet read_rangefinder_sheet(const ConfigNode& node);
CAS_BASE_EXPORT LidarSheet read_lidar_sheet(const ConfigNode& node);
CAS_BASE_EXPORT AirspeedSheet read_airspeed_sheet(const ConfigNode& node);
CAS_BASE_EXPORT OdometrySheet read_odometry_sheet(const ConfigNode& node);

/// Every key of these sheets with its default and meaning, as tables in Markdown: for `hilsim
/// --sensor-keys` and docs/use/plugins.md.
CAS_BASE_EXPORT std::string sensor_reference();

}  // namespace cas::base
