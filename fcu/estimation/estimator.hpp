// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstdint>
#include <optional>

#include "base/earth/geodesy.hpp"
#include "base/earth/magnetic_field.hpp"
#include "base/time/clock.hpp"
#include "fcu/estimation/alignment.hpp"
#include "fcu/estimation/error_covariance.hpp"
#include "fcu/estimation/estimator_params.hpp"
#include "fcu/estimation/motion_history.hpp"

namespace cas::fcu {

/// One inertial sample, axes of D.
struct ImuInput {
  base::SimTime time;
  Eigen::Vector3d gyro_D;   ///< rad/s
  Eigen::Vector3d accel_D;  ///< specific force, m/s^2
};

/// One position fix.
struct GpsInput {
  base::SimTime time;  ///< of measurement
  int fix_type = 0;    ///< GPS_FIX_TYPE; below 3 the fix is not used
  base::Geodetic place;
  Eigen::Vector3d velocity_N = Eigen::Vector3d::Zero();  ///< m/s
};

/// The nominal state. N begins at the origin that the first fixes gave.
struct EstimatorState {
  base::SimTime time;
  Eigen::Quaterniond q_ND = Eigen::Quaterniond::Identity();  ///< turns vectors from D into N
  Eigen::Vector3d v_N = Eigen::Vector3d::Zero();             ///< m/s
  Eigen::Vector3d p_N = Eigen::Vector3d::Zero();             ///< m, from the origin
  Eigen::Vector3d w_D = Eigen::Vector3d::Zero();             ///< body rates without bias, rad/s
  Eigen::Vector3d a_N = Eigen::Vector3d::Zero();             ///< acceleration, m/s^2
  Eigen::Vector3d gyro_bias_D = Eigen::Vector3d::Zero();     ///< rad/s
  Eigen::Vector3d accel_bias_D = Eigen::Vector3d::Zero();    ///< m/s^2
  Eigen::Vector3d earth_field_N = Eigen::Vector3d::Zero();   ///< gauss
  Eigen::Vector3d body_field_D = Eigen::Vector3d::Zero();    ///< gauss
  double baro_offset_m = 0;  ///< pressure altitude minus altitude of the estimate
};

/// How one kind of measurement fares.
struct FusionHealth {
  double test_ratio = 0;  ///< largest innovation over its gate, squared; above 1 is rejected
  double nis = 0;         ///< normalised innovation squared of the last fused measurement
  int dimension = 0;      ///< its expected value
  std::uint64_t fused = 0;
  std::uint64_t rejected = 0;
  base::SimTime last_fused;
};

/// Error-state Kalman filter on inertial, position, magnetic and pressure measurements: attitude,
/// velocity, position, gyro and accelerometer bias, earth and body magnetic field, barometer
/// offset.
///
/// The nominal state is integrated with every IMU sample (trapezoid); errors live in N
/// (global-frame error quaternion, J. Solà, "Quaternion kinematics for the error-state Kalman
/// filter", 2017, Sect. 7). Late position fixes are compared with the state at their own time.
/// At rest (`set_at_rest`) zero velocity and zero rate are measurements too.
class Estimator {
 public:
  explicit Estimator(const EstimatorParams& params = {}, double decimal_year = base::kUsualYear);

  void set_params(const EstimatorParams& params) { params_ = params; }
  const EstimatorParams& params() const { return params_; }
  /// Fixes the origin of N (instead of the first fixes). Only before the first fix.
  void set_origin(const base::Geodetic& origin);
  /// Tells whether the controller takes the vehicle to be at rest on the ground.
  void set_at_rest(bool at_rest) { at_rest_ = at_rest; }
  /// Time, in s, for which both set_at_rest(true) and the IMU have indicated rest.
  double rest_s() const;

  /// Measurements, each with its own time; values that are not finite are ignored.
  void on_imu(const ImuInput& imu);
  void on_magnetometer(base::SimTime time, const Eigen::Vector3d& field_D_gauss);
  void on_barometer(base::SimTime time, double pressure_pa);
  void on_gps(const GpsInput& fix);
  /// From now on the samples are those of another IMU, whose biases are not known.
  void forget_imu_biases();
  /// How far a fix is from the estimate at its time, horizontally.
  struct FixOffset {
    double position_m = 0;
    double velocity_m_s = 0;
  };
  /// @return nullopt before the first fix was used, and while position_valid() is false
  std::optional<FixOffset> offset_of(const GpsInput& fix) const;

  const EstimatorState& state() const { return state_; }
  const ErrorCovariance& covariance() const { return covariance_; }
  const std::optional<base::LocalProjection>& projection() const { return projection_; }

  bool aligned() const { return aligned_; }  ///< attitude known
  bool heading_valid() const { return aligned_ && heading_aligned_; }
  bool velocity_valid() const;  ///< horizontal velocity usable
  bool position_valid() const;  ///< horizontal position usable
  bool height_valid() const;
  /// Position known well enough to take off from: the origin will not move any more.
  bool origin_final() const { return origin_final_; }

  const FusionHealth& gps_position() const { return gps_position_; }
  const FusionHealth& gps_velocity() const { return gps_velocity_; }
  const FusionHealth& baro() const { return baro_; }
  const FusionHealth& mag() const { return mag_; }
  /// Times the position was reset to the fixes after a long rejection; a setpoint must follow.
  std::uint64_t position_resets() const { return position_resets_; }
  /// The velocities of the last fixes are not the change of their positions; they are not used.
  bool gps_contradicts_itself() const { return velocity_rejections_ >= kContradictions; }
  /// How far the last of them moved the position, m.
  Eigen::Vector3d last_position_reset_N() const { return last_position_reset_N_; }

 private:
  using Vector = ErrorCovariance::Vector;

  void align(const ImuInput& imu);
  void start_covariance();
  void align_heading(const Eigen::Vector3d& field_D);
  void set_field_from_model(const base::Geodetic& place);
  void predict(const ImuInput& imu);
  void fuse_rest(base::SimTime time);
  /// @return the normalised innovation squared, after the measurements fused since apply_errors()
  double fuse_scalar(const Vector& h, double innovation, double variance);
  bool passes(const Vector& h, double innovation, double variance, double gate,
              FusionHealth& health);
  void apply_errors();
  Vector position_row(int axis, double age_s) const;
  Vector velocity_row(int axis, double age_s) const;
  void fuse_gps_position(const GpsInput& fix, const Eigen::Vector3d& measured_N);
  void fuse_gps_velocity(const GpsInput& fix, const Eigen::Vector3d& measured_N);
  bool velocity_fits_positions(const GpsInput& fix, const Eigen::Vector3d& measured_N) const;
  void accept_first_fix(const GpsInput& fix);
  void reset_to_fix(const GpsInput& fix, const Eigen::Vector3d& measured_N);
  void settle_origin();

  EstimatorParams params_;
  double decimal_year_;
  EstimatorState state_;
  ErrorCovariance covariance_;
  MotionHistory history_;
  std::optional<base::LocalProjection> projection_;
  Alignment alignment_;
  std::optional<ImuInput> last_imu_;
  Vector errors_ = Vector::Zero();  ///< corrections found, not yet applied
  Eigen::Vector3d rest_gyro_sum_ = Eigen::Vector3d::Zero();
  int rest_samples_ = 0;
  std::optional<base::SimTime> rest_since_;
  base::SimTime first_fix_;
  bool aligned_ = false;
  bool heading_aligned_ = false;
  bool field_known_ = false;
  bool baro_started_ = false;
  bool at_rest_ = false;
  bool origin_given_ = false;
  bool origin_final_ = false;
  FusionHealth gps_position_, gps_velocity_, baro_, mag_;
  /// Rejected velocities in a row that are told of: more than those after which a blow is believed.
  static constexpr int kContradictions = 8;
  int velocity_rejections_ = 0;
  base::SimTime first_rejected_;  ///< of those: time, place and sum
  Eigen::Vector3d first_rejected_N_ = Eigen::Vector3d::Zero();
  Eigen::Vector3d rejected_velocity_sum_N_ = Eigen::Vector3d::Zero();
  std::uint64_t position_resets_ = 0;
  Eigen::Vector3d last_position_reset_N_ = Eigen::Vector3d::Zero();
};

}  // namespace cas::fcu
