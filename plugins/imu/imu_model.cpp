// SPDX-License-Identifier: BSD-3-Clause
#include "plugins/imu/imu_model.hpp"

#include <cmath>

#include "base/angles.hpp"
#include "base/config/sensor_sheets.hpp"
#include "base/earth/frames.hpp"
#include "plugins/common/gauss_markov.hpp"
#include "plugins/common/noise_params.hpp"

namespace cas::sim {

// Configuration.

namespace {

/// (I + scale errors) * (small rotation of the axes against the case).
Eigen::Matrix3d sensitivity(const base::TriadSheet& sheet) {
  const Eigen::Vector3d angles = sheet.misalignment_deg * base::kRadPerDeg;
  const Eigen::Vector3d gain = Eigen::Vector3d::Ones() + sheet.scale_error;
  const Eigen::Matrix3d turn =
      base::quaternion_rpy(angles.x(), angles.y(), angles.z()).toRotationMatrix().transpose();
  return gain.asDiagonal() * turn;
}

/// @param si  the sheet's unit in SI
TriadParams triad_params(const base::TriadSheet& sheet, double si, double rate_hz) {
  return {.stddev = white_noise(sheet.noise, si, rate_hz),
          .bias = sheet.bias * si,
          .turn_on_bias_stddev = sheet.turn_on_bias_stddev * si,
          .bias_walk = drift_of(sheet.drift, si),
          .sensitivity = sensitivity(sheet),
          .range = sheet.range * si,
          .lsb = sheet.lsb * si,
          .vibration = sheet.vibration * si,
          .temperature = sheet.temperature * si,
          .temperature_squared = sheet.temperature_squared * si};
}

}  // namespace

ImuParams parse_imu_params(const base::ConfigNode& node, double step_s) {
  const base::ImuSheet sheet = base::read_imu_sheet(node);
  check_rate(node, sheet.rate_hz, step_s);
  const Eigen::Vector3d rpy = sheet.mounting_rpy_deg * base::kRadPerDeg;
  return {.rate_hz = sheet.rate_hz,
          .position_B_m = sheet.position_B_m,
          .R_SB = base::quaternion_rpy(rpy.x(), rpy.y(), rpy.z()).toRotationMatrix().transpose(),
          .gyro = triad_params(sheet.gyro, base::kRadPerDeg, sheet.rate_hz),
          .accel = triad_params(sheet.accel, 1.0, sheet.rate_hz),
          .gyro_g_sensitivity = sheet.gyro_g_sensitivity_deg_s_per_m_s2 * base::kRadPerDeg,
          .vibration_reference_rad_s = sheet.vibration_reference_rad_s,
          .vibration_harmonics = sheet.vibration_harmonics,
          .vibration_imbalance = sheet.vibration_imbalance,
          .start_degc = sheet.start_degc,
          .warm_up_degc = sheet.warm_up_degc,
          .warm_up_time_constant_s = sheet.warm_up_time_constant_s};
}

// Model.

TriadErrors::TriadErrors(const TriadParams& params, double dt_s, base::NormalRandom& random)
    : params_(params),
      bias_(params.bias + params.turn_on_bias_stddev.cwiseProduct(normal3(random))),
      walk_(params.bias_walk, dt_s) {}

Eigen::Vector3d TriadErrors::sample(const Eigen::Vector3d& truth, const Eigen::Vector3d& vibration,
                                    double degc, base::NormalRandom& random) {
  Eigen::Vector3d value = params_.sensitivity * truth + bias_ + walk_.advance(random);
  value += params_.vibration.cwiseProduct(vibration);
  value += params_.temperature * degc + params_.temperature_squared * (degc * degc);
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
  const double degc = temperature_degc(time);
  const Eigen::Vector3d force_S = params_.R_SB * specific_force_sum_B_ * inverse_time;
  const Eigen::Vector3d rate_S =
      params_.R_SB * rate_sum_B_ * inverse_time + params_.gyro_g_sensitivity.cwiseProduct(force_S);
  sample.angular_rate_B = gyro_.sample(rate_S, vibration, degc, random_);
  sample.specific_force_B = accel_.sample(force_S, vibration, degc, random_);
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
    const auto rotor = static_cast<std::size_t>(i);
    const bool is_listed = rotor < params_.vibration_imbalance.size();
    const double amplitude =
        is_listed ? imbalance_[i] * params_.vibration_imbalance[rotor] : imbalance_[i];
    const double phase = phases_[rotor];
    const double quadrature = std::sin(phase);
    sum += amplitude * Eigen::Vector3d(std::cos(phase), quadrature, quadrature);
    for (std::size_t n = 0; n < params_.vibration_harmonics.size(); ++n) {
      const double multiple = static_cast<double>(n + 2) * phase;
      const double across = std::sin(multiple);
      sum += amplitude * params_.vibration_harmonics[n] *
             Eigen::Vector3d(std::cos(multiple), across, across);
    }
  }
  return sum;
}

double ImuModel::temperature_degc(base::SimTime time) const {
  if (params_.warm_up_degc == 0) return params_.start_degc;
  const double time_s = base::to_seconds(time);
  return params_.start_degc -
         params_.warm_up_degc * std::expm1(-time_s / params_.warm_up_time_constant_s);
}

}  // namespace cas::sim
