// SPDX-License-Identifier: BSD-3-Clause
#include "plugins/imu/imu_model.hpp"

#include <cmath>

#include "base/earth/frames.hpp"
#include "plugins/common/gauss_markov.hpp"
#include "plugins/common/noise_params.hpp"

namespace cas::sim {

// Configuration.

namespace {

constexpr double kRadPerDeg = M_PI / 180.0;
constexpr double kLargestScaleError = 0.5;

double get_positive_or_off(const base::ConfigNode& node, const std::string& key) {
  const double value = node.get(key, 0.0);
  if (value < 0.0) node.at(key).fail("must not be negative (0 switches it off)");
  return value;
}

/// (I + scale errors) * (small rotation of the axes against the case).
Eigen::Matrix3d parse_sensitivity(const base::ConfigNode& node, const std::string& name) {
  const Eigen::Vector3d scale_error = get_axes(node, name + "scale_error");
  const Eigen::Vector3d angles = get_axes(node, name + "misalignment_deg") * kRadPerDeg;
  if ((scale_error.array().abs() > kLargestScaleError).any()) {
    node.at(name + "scale_error").fail("is a fraction, at most 0.5");
  }
  const Eigen::Vector3d gain = Eigen::Vector3d::Ones() + scale_error;
  const Eigen::Matrix3d turn =
      base::quaternion_rpy(angles.x(), angles.y(), angles.z()).toRotationMatrix().transpose();
  return gain.asDiagonal() * turn;
}

TriadParams parse_triad(const base::ConfigNode& node, const Quantity& quantity, double rate_hz) {
  const std::string& name = quantity.name;
  const double si = quantity.to_si;
  TriadParams triad;
  triad.stddev = parse_white_noise(node, quantity, rate_hz);
  triad.bias = get_axes(node, name + "bias_" + quantity.unit) * si;
  triad.turn_on_bias_stddev = get_axes(node, name + "turn_on_bias_stddev_" + quantity.unit) * si;
  triad.bias_walk = parse_drift(node, quantity);
  triad.sensitivity = parse_sensitivity(node, name);
  triad.range = get_positive_or_off(node, name + "range_" + quantity.unit) * si;
  triad.lsb = get_positive_or_off(node, name + "lsb_" + quantity.unit) * si;
  triad.vibration = get_axes(node, name + "vibration_" + quantity.unit) * si;
  return triad;
}

}  // namespace

ImuParams parse_imu_params(const base::ConfigNode& node, double step_s) {
  ImuParams params;
  params.rate_hz = parse_rate(node, step_s);
  params.position_B_m = get_axes(node, "position_B_m");
  const Eigen::Vector3d rpy = get_axes(node, "mounting_rpy_deg") * kRadPerDeg;
  params.R_SB = base::quaternion_rpy(rpy.x(), rpy.y(), rpy.z()).toRotationMatrix().transpose();
  params.gyro = parse_triad(node, {"gyro_", "deg_s", kRadPerDeg}, params.rate_hz);
  params.accel = parse_triad(node, {"accel_", "m_s2", 1.0}, params.rate_hz);
  const bool vibrates = !params.gyro.vibration.isZero(0.0) || !params.accel.vibration.isZero(0.0);
  params.vibration_reference_rad_s = get_positive_or_off(node, "vibration_reference_rad_s");
  if (vibrates && params.vibration_reference_rad_s <= 0.0) {
    node.fail("gives a vibration amplitude without vibration_reference_rad_s");
  }
  return params;
}

// Model.

TriadErrors::TriadErrors(const TriadParams& params, double dt_s, base::NormalRandom& random)
    : params_(params),
      bias_(params.bias + params.turn_on_bias_stddev.cwiseProduct(normal3(random))),
      walk_(params.bias_walk, dt_s) {}

Eigen::Vector3d TriadErrors::sample(const Eigen::Vector3d& truth, const Eigen::Vector3d& vibration,
                                    base::NormalRandom& random) {
  Eigen::Vector3d value = params_.sensitivity * truth + bias_ + walk_.advance(random);
  value += params_.vibration.cwiseProduct(vibration);
  value += params_.stddev.cwiseProduct(normal3(random));
  if (params_.range > 0) value = value.cwiseMax(-params_.range).cwiseMin(params_.range);
  if (params_.lsb > 0) value = (value / params_.lsb).array().round().matrix() * params_.lsb;
  return value;
}

ImuModel::ImuModel(const ImuParams& params, std::uint64_t seed)
    : params_(params),
      random_(seed),
      gyro_(params.gyro, 1.0 / params.rate_hz, random_),
      accel_(params.accel, 1.0 / params.rate_hz, random_),
      vibrates_(params.vibration_reference_rad_s > 0) {
  // Four are drawn whatever the vehicle has, so that its noise does not depend on its rotors.
  constexpr std::size_t kDrawn = 4;
  constexpr double kGoldenAngle_rad = 2.399963229728653;
  for (std::size_t i = 0; i < phases_.size(); ++i) {
    phases_[i] = i < kDrawn ? 2.0 * M_PI * random_.uniform()
                            : std::fmod(phases_[i - kDrawn] + kGoldenAngle_rad, 2.0 * M_PI);
  }
}

void ImuModel::accumulate(const BodyState& state, const Eigen::Vector3d& gravity_W, double dt) {
  // a_WB and alpha_WB_B are means over the step, so everything is taken at its middle: w half a
  // step back, and the attitude turned back by half a step (first order).
  const Eigen::Vector3d& alpha_B = state.alpha_WB_B;
  const Eigen::Vector3d w_B = state.w_WB_B - alpha_B * (0.5 * dt);
  const Eigen::Vector3d f_end_B = state.q_WB.conjugate() * (state.a_WB - gravity_W);
  const Eigen::Vector3d f_B = f_end_B + (w_B * (0.5 * dt)).cross(f_end_B);

  // Rigid-body lever arm: f_P = f + alpha x r + w x (w x r).
  const Eigen::Vector3d& r_B = params_.position_B_m;
  specific_force_sum_B_ += (f_B + alpha_B.cross(r_B) + w_B.cross(w_B.cross(r_B))) * dt;
  rate_sum_B_ += w_B * dt;
  time_sum_ += dt;
}

void ImuModel::advance_vibration(const base::RotorVector& omega, double dt) {
  if (!vibrates_) return;
  imbalance_ = (omega / params_.vibration_reference_rad_s).cwiseAbs2();
  for (int i = 0; i < omega.size(); ++i) {
    double& phase = phases_[static_cast<std::size_t>(i)];
    phase = std::fmod(phase + omega[i] * dt, 2.0 * M_PI);
  }
}

ImuSample ImuModel::sample(base::SimTime time, const BodyState& state) {
  const Eigen::Vector3d vibration = unit_vibration();
  const double inverse_time = time_sum_ > 0 ? 1.0 / time_sum_ : 0.0;
  ImuSample sample;
  sample.time = time;
  sample.angular_rate_B =
      gyro_.sample(params_.R_SB * rate_sum_B_ * inverse_time, vibration, random_);
  sample.specific_force_B =
      accel_.sample(params_.R_SB * specific_force_sum_B_ * inverse_time, vibration, random_);
  sample.q_WB = state.q_WB;
  specific_force_sum_B_.setZero();
  rate_sum_B_.setZero();
  time_sum_ = 0;
  return sample;
}

Eigen::Vector3d ImuModel::unit_vibration() const {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  if (!vibrates_) return sum;
  for (int i = 0; i < imbalance_.size(); ++i) {
    const double phase = phases_[static_cast<std::size_t>(i)];
    const double quadrature = std::sin(phase);
    sum += imbalance_[i] * Eigen::Vector3d(std::cos(phase), quadrature, quadrature);
  }
  return sum;
}

}  // namespace cas::sim
