// SPDX-License-Identifier: BSD-3-Clause
#include "base/config/vehicle.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "base/earth/gravity.hpp"
#include "base/error.hpp"

namespace cas::base {
namespace {

/// Force and moment of one rotor for each omega^2, its axis along `axis_B`.
Eigen::Matrix<double, 6, 1> wrench_of(const Rotor& rotor, const Eigen::Vector3d& axis_B) {
  const double share = rotor.wake ? rotor.wake->thrust_share : 1.0;
  const Eigen::Vector3d force_B = share * rotor.params.thrust_coefficient * axis_B;
  Eigen::Matrix<double, 6, 1> wrench;
  wrench.head<3>() = force_B;
  // A rotor's reaction torque is against its spin.
  wrench.tail<3>() =
      rotor.position_B_m.cross(force_B) - rotor.spin * rotor.params.torque_coefficient * axis_B;
  return wrench;
}

/// (U1, U2, U3, U4) in the axes of D of a force and moment in B.
Eigen::Vector4d control_inputs(const Eigen::Matrix<double, 6, 1>& wrench) {
  return {wrench[2], wrench[3], -wrench[4], -wrench[5]};
}

/// The smaller of two moments of opposite sign; where the rotors give one only, that one.
double balanced(double positive, double negative) {
  const double smaller = std::min(positive, negative);
  return smaller > 0 ? smaller : std::max(positive, negative);
}

/// Vehicle::hover_output() where the thrust is no polynomial of the output. It grows with it.
std::optional<double> searched_hover_output(const Vehicle& vehicle, double weight_n) {
  const auto missing = [&](double output) {
    double lift = 0;
    for (const Rotor& rotor : vehicle.rotors) {
      const double omega = rotor.speed_at(output);
      lift += wrench_of(rotor, rotor.axis_B)[2] * omega * omega;
    }
    return weight_n - lift;
  };
  double low = 0;
  double high = 1;
  if (missing(low) < 0 || missing(high) > 0) return std::nullopt;
  constexpr int kHalvings = 52;
  for (int i = 0; i < kHalvings; ++i) {
    const double middle = 0.5 * (low + high);
    (missing(middle) > 0 ? low : high) = middle;
  }
  return high;
}

}  // namespace

Eigen::Vector3d Rotor::tilted_axis_B(double tilt_rad) const {
  if (!tilt) return axis_B;
  return Eigen::AngleAxisd(tilt_rad, tilt->axis_B) * axis_B;
}

double Rotor::speed_at(double output_value) const {
  const double idle = params.omega_idle_rad_s;
  if (!electric) return idle + output_value * (params.omega_max_rad_s - idle);
  const double least = electric->steady_duty(idle, params.torque_coefficient);
  return electric->steady_speed_rad_s(least + output_value * (1 - least),
                                      params.torque_coefficient);
}

double Rotor::output_at(double omega_rad_s) const {
  const double idle = params.omega_idle_rad_s;
  if (!electric) return (omega_rad_s - idle) / (params.omega_max_rad_s - idle);
  const double least = electric->steady_duty(idle, params.torque_coefficient);
  return (electric->steady_duty(omega_rad_s, params.torque_coefficient) - least) / (1 - least);
}

Effectiveness Vehicle::effectiveness(std::span<const double> tilt_rad) const {
  CAS_CHECK(tilt_rad.empty() || tilt_rad.size() == rotors.size());
  Effectiveness columns(6, rotor_count());
  for (std::size_t i = 0; i < rotors.size(); ++i) {
    const Rotor& rotor = rotors[i];
    columns.col(static_cast<Eigen::Index>(i)) =
        wrench_of(rotor, tilt_rad.empty() ? rotor.axis_B : rotor.tilted_axis_B(tilt_rad[i]));
  }
  return columns;
}

ControlScales Vehicle::control_scales() const {
  Eigen::Vector4d positive = Eigen::Vector4d::Zero();
  Eigen::Vector4d negative = Eigen::Vector4d::Zero();
  for (const Rotor& rotor : rotors) {
    const double omega_sq = std::pow(rotor.params.omega_max_rad_s, 2);
    Eigen::Vector4d most = Eigen::Vector4d::Zero();   // of this rotor's contribution
    Eigen::Vector4d least = Eigen::Vector4d::Zero();  // and takes away
    const auto consider = [&](double tilt) {
      const Eigen::Vector4d u =
          control_inputs(wrench_of(rotor, rotor.tilted_axis_B(tilt))) * omega_sq;
      most = most.cwiseMax(rotor.params.reversible ? Eigen::Vector4d(u.cwiseAbs()) : u);
      least = least.cwiseMax(rotor.params.reversible ? Eigen::Vector4d(u.cwiseAbs()) : -u);
    };
    consider(0);
    if (rotor.tilt) {
      consider(rotor.tilt->min_rad);
      consider(rotor.tilt->max_rad);
    }
    positive += most;
    negative += least;
  }
  return {.u1_max_n = positive[0],
          .u2_max_nm = balanced(positive[1], negative[1]),
          .u3_max_nm = balanced(positive[2], negative[2]),
          .u4_max_nm = balanced(positive[3], negative[3])};
}

void Vehicle::settle_lags() {
  const double output = hover_output(kStandardGravity_m_s2).value_or(1.0);
  for (Rotor& rotor : rotors) {
    if (!rotor.electric) continue;
    rotor.params.time_constant_up_s = rotor.params.time_constant_down_s = rotor.electric->lag_s(
        rotor.params.inertia_kg_m2, rotor.params.torque_coefficient, rotor.speed_at(output));
  }
}

std::optional<double> Vehicle::hover_output(double gravity_m_s2) const {
  if (std::ranges::any_of(rotors, [](const Rotor& rotor) { return rotor.electric.has_value(); })) {
    return searched_hover_output(*this, mass_kg * gravity_m_s2);
  }
  // Upward thrust as a polynomial of u: each rotor's is quadratic.
  double constant = 0;
  double linear = 0;
  double square = 0;
  for (const Rotor& rotor : rotors) {
    const double lift = wrench_of(rotor, rotor.axis_B)[2];
    const double idle = rotor.params.omega_idle_rad_s;
    const double range = rotor.params.omega_max_rad_s - idle;
    constant += lift * idle * idle;
    linear += 2 * lift * idle * range;
    square += lift * range * range;
  }
  const double missing = mass_kg * gravity_m_s2 - constant;
  if (missing < 0 || missing > linear + square) return std::nullopt;
  // square u^2 + linear u = missing, in the form that allows square = 0
  const double root = std::sqrt(linear * linear + 4 * square * missing);
  return missing > 0 ? 2 * missing / (linear + root) : 0.0;
}

Eigen::Matrix4d Vehicle::mixing_matrix() const {
  CAS_CHECK(rotor_count() == 4);
  const Effectiveness columns = effectiveness();
  Eigen::Matrix4d mixer;
  for (int i = 0; i < 4; ++i) mixer.col(i) = control_inputs(columns.col(i));
  return mixer;
}

}  // namespace cas::base
