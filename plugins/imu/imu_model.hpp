// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <cstdint>
#include <vector>

#include "base/config/config.hpp"
#include "base/config/vehicle.hpp"
#include "base/random.hpp"
#include "base/time/clock.hpp"
#include "libsim/api/messages.hpp"
#include "libsim/api/world.hpp"
#include "plugins/common/gauss_markov.hpp"

namespace cas::sim {

/// Errors of one triad of axes (gyroscope or accelerometer), in SI. Zero switches an error off.
struct TriadParams {
  Eigen::Vector3d stddev = Eigen::Vector3d::Zero();  ///< white noise, deviation of one sample
  Eigen::Vector3d bias = Eigen::Vector3d::Zero();    ///< constant, the same in every run
  Eigen::Vector3d turn_on_bias_stddev = Eigen::Vector3d::Zero();  ///< drawn once per run
  GaussMarkovParams<3> bias_walk;                                 ///< in-run drift of the bias
  Eigen::Matrix3d sensitivity = Eigen::Matrix3d::Identity();      ///< scale errors and misalignment
  double range = 0;                                               ///< clips at +-range
  double lsb = 0;                                                 ///< rounds to multiples
  Eigen::Vector3d vibration =
      Eigen::Vector3d::Zero();  ///< amplitude per rotor at vibration_reference_rad_s
  Eigen::Vector3d temperature = Eigen::Vector3d::Zero();          ///< bias per degree
  Eigen::Vector3d temperature_squared = Eigen::Vector3d::Zero();  ///< and per its square
};

struct ImuParams {
  double rate_hz = 0;
  Eigen::Vector3d position_B_m = Eigen::Vector3d::Zero();  ///< from the centre of gravity
  Eigen::Matrix3d R_SB = Eigen::Matrix3d::Identity();      ///< B to the sensor's own axes
  TriadParams gyro;
  TriadParams accel;
  Eigen::Vector3d gyro_g_sensitivity = Eigen::Vector3d::Zero();  ///< rad/s per m/s^2, by axis
  double vibration_reference_rad_s = 0;
  std::vector<double> vibration_harmonics;  ///< of the 2nd, 3rd, ..., fraction of the first
  std::vector<double> vibration_imbalance;  ///< of each rotor; 1 for those that it does not list
  double start_degc = 0;                    ///< above the calibration's temperature
  double warm_up_degc = 0;
  double warm_up_time_constant_s = 0;
};

/// Reads the block `imu`: its keys are those of its sheet (base/config/sensor_sheets.hpp).
/// @param step_s  the simulation's step
ImuParams parse_imu_params(const base::ConfigNode& node, double step_s);

/// Error chain of three axes: sensitivity, biases, vibration, temperature, white noise, range,
/// resolution.
class TriadErrors {
 public:
  TriadErrors() = default;
  /// Draws the turn-on bias.
  TriadErrors(const TriadParams& params, double dt_s, base::NormalRandom& random);

  /// @param truth      mean over the sample period, in the sensor's axes
  /// @param vibration  this moment's vibration for amplitude 1
  /// @param degc       temperature above the calibration's
  Eigen::Vector3d sample(const Eigen::Vector3d& truth, const Eigen::Vector3d& vibration,
                         double degc, base::NormalRandom& random);

 private:
  TriadParams params_;
  Eigen::Vector3d bias_ = Eigen::Vector3d::Zero();
  GaussMarkov<3> walk_;
};

/// Gyroscope and accelerometer at a point of the body.
///
/// Truth is averaged over the sample period, as integrating sensors do, so that samples do not
/// depend on the simulation's step. Vibration comes from the imbalance of each rotor at its speed:
/// amplitude * (omega / reference)^2 at the rotor's own phase and its multiples, sampled (and so
/// aliased) at the sample's moment. The sensor warms up exponentially from the start of the run.
/// The analog filter's lag, the air's temperature and that of scale factors are not modelled.
class ImuModel {
 public:
  ImuModel() = default;
  ImuModel(const ImuParams& params, std::uint64_t seed);

  /// Takes in one step of motion. @param state  at the end of the step
  void accumulate(const BodyState& state, const Eigen::Vector3d& gravity_W, double dt);
  /// Turns the rotors' imbalance on by dt. @param omega  rotor speeds, rad/s
  void advance_vibration(const base::RotorVector& omega, double dt);
  /// The mean over the steps since the last call, with errors.
  ImuSample sample(base::SimTime time, const BodyState& state);

  const ImuParams& params() const { return params_; }

 private:
  Eigen::Vector3d unit_vibration() const;
  double temperature_degc(base::SimTime time) const;

  ImuParams params_;
  base::NormalRandom random_;
  TriadErrors gyro_;
  TriadErrors accel_;
  bool vibrates_ = false;
  std::array<double, base::kMaxRotors> phases_{};
  base::RotorVector imbalance_;  // (omega / reference)^2
  Eigen::Vector3d specific_force_sum_B_ = Eigen::Vector3d::Zero();
  Eigen::Vector3d rate_sum_B_ = Eigen::Vector3d::Zero();
  double time_sum_ = 0;
};

}  // namespace cas::sim
