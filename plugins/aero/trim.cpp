// SPDX-License-Identifier: BSD-3-Clause
#include "plugins/aero/trim.hpp"

#include <Eigen/Geometry>
#include <Eigen/QR>
#include <cmath>

#include "base/earth/frames.hpp"

namespace cas::sim {
namespace {

using Accelerations = Eigen::Matrix<double, 6, 1>;
using Unknowns = Eigen::Matrix<double, 7, 1>;  // alpha, beta, roll, throttle, three moments

constexpr double kStep = 1e-6;  // of differences: rad, or a share of the throttle
constexpr double kStartAlpha_rad = 0.05;
constexpr double kStartThrottle = 0.6;

/// Pitch of level flight: the velocity (u, v, w) has no part down.
double level_pitch(const Eigen::Vector3d& v_D, double roll_rad) {
  return std::atan2(v_D.y() * std::sin(roll_rad) + v_D.z() * std::cos(roll_rad), v_D.x());
}

Eigen::Vector3d velocity_D(double speed, double alpha_rad, double beta_rad) {
  return speed * Eigen::Vector3d(std::cos(alpha_rad) * std::cos(beta_rad), std::sin(beta_rad),
                                 std::sin(alpha_rad) * std::cos(beta_rad));
}

Accelerations accelerations(const Airframe& airframe, const Trim& trim) {
  return state_rates(airframe, state_of(trim), trim.deflections_rad, trim.throttle).head<6>();
}

/// Solves for the trim; has the place of every unknown and the surfaces' allocation.
class TrimSearch {
 public:
  TrimSearch(const Airframe& airframe, double speed_m_s)
      : airframe_(airframe), speed_m_s_(speed_m_s) {
    allocate();
  }

  std::optional<Trim> solve() const {
    constexpr int kMostSteps = 100;
    constexpr double kBalanced = 1e-11;  // m/s^2, rad/s^2
    constexpr double kGoodEnough = 1e-7;
    Unknowns z = Unknowns::Zero();
    z[0] = kStartAlpha_rad;
    z[3] = kStartThrottle;
    Accelerations rest = accelerations(airframe_, trim_of(z));
    for (int i = 0; i < kMostSteps && rest.cwiseAbs().maxCoeff() > kBalanced; ++i) {
      if (!improve(z, rest)) break;
    }
    if (!(rest.cwiseAbs().maxCoeff() < kGoodEnough)) return std::nullopt;
    const bool flies_forwards = std::abs(z[0]) < M_PI / 2 && std::abs(z[2]) < M_PI / 2;
    return flies_forwards ? std::optional(trim_of(z)) : std::nullopt;
  }

 private:
  /// Deflections by the moments wanted of them: the pseudo-inverse of their effects.
  void allocate() {
    const auto count = static_cast<Eigen::Index>(airframe_.surfaces);
    Trim still{.speed_m_s = speed_m_s_,
               .alpha_rad = kStartAlpha_rad,
               .deflections_rad = std::vector<double>(airframe_.surfaces)};
    Eigen::MatrixXd effects(3, count);
    for (Eigen::Index i = 0; i < count; ++i) {
      Trim turned = still;
      turned.deflections_rad[static_cast<std::size_t>(i)] = kStep;
      effects.col(i) =
          (accelerations(airframe_, turned) - accelerations(airframe_, still)).tail<3>() / kStep;
    }
    constexpr double kNothing = 1e-4;  // of the greatest effect
    Eigen::CompleteOrthogonalDecomposition<Eigen::MatrixXd> solver;
    solver.setThreshold(kNothing);
    solver.compute(effects);
    allocation_ = solver.pseudoInverse();
    holds_heading_ = count > 0 && solver.rank() == 3;
  }

  Trim trim_of(const Unknowns& z) const {
    Trim trim{.speed_m_s = speed_m_s_,
              .alpha_rad = z[0],
              .beta_rad = z[1],
              .roll_rad = z[2],
              .throttle = z[3],
              .deflections_rad = std::vector<double>(airframe_.surfaces)};
    trim.pitch_rad = level_pitch(velocity_D(speed_m_s_, z[0], z[1]), z[2]);
    Eigen::VectorXd::Map(trim.deflections_rad.data(), allocation_.rows()) =
        allocation_ * z.tail<3>();
    return trim;
  }

  /// One step. @return false where no step helps any more
  bool improve(Unknowns& z, Accelerations& rest) const {
    Eigen::Matrix<double, 6, 7> slope;
    for (int j = 0; j < z.size(); ++j) {
      const double h = j < 4 ? kStep : 1e3 * kStep;  // moments are rad/s^2
      Unknowns up = z;
      Unknowns down = z;
      up[j] += h;
      down[j] -= h;
      slope.col(j) =
          (accelerations(airframe_, trim_of(up)) - accelerations(airframe_, trim_of(down))) /
          (2 * h);
    }
    if (holds_heading_) slope.col(1).setZero();  // sideslip stays 0
    Unknowns step = slope.completeOrthogonalDecomposition().solve(rest);
    constexpr int kMostHalves = 12;
    for (int i = 0; i < kMostHalves; ++i, step *= 0.5) {
      const Unknowns next = z - step;
      const Accelerations left = accelerations(airframe_, trim_of(next));
      if (!(left.norm() < rest.norm())) continue;
      z = next;
      rest = left;
      return true;
    }
    return false;
  }

  const Airframe& airframe_;
  double speed_m_s_;
  Eigen::MatrixXd allocation_;
  bool holds_heading_ = false;
};

}  // namespace

BodyState body_of(const FlightState& state) {
  BodyState body;
  body.q_WB = base::q_WB_from_q_ND(base::quaternion_rpy(state[6], state[7], 0));
  body.v_WB = body.q_WB * base::swap_BD(state.head<3>());
  body.w_WB_B = base::swap_BD(state.segment<3>(3));
  return body;
}

FlightState state_rates(const Airframe& airframe, const FlightState& state,
                        std::span<const double> deflections, double throttle) {
  const BodyState body = body_of(state);
  const Wrench wrench = airframe.wrench(body, deflections, throttle);
  const Eigen::Vector3d& w_B = body.w_WB_B;
  const Eigen::Vector3d v_B = body.q_WB.conjugate() * body.v_WB;
  const Eigen::Vector3d g_B = body.q_WB.conjugate() * airframe.air.gravity_W;
  const Eigen::Vector3d v_dot_B = wrench.force_B / airframe.mass_kg + g_B - w_B.cross(v_B);
  const Eigen::Vector3d w_dot_B = airframe.inertia_B.ldlt().solve(
      wrench.torque_B - w_B.cross(Eigen::Vector3d(airframe.inertia_B * w_B)));

  FlightState rates;
  rates.head<3>() = base::swap_BD(v_dot_B);
  rates.segment<3>(3) = base::swap_BD(w_dot_B);
  const double q = state[4];
  const double r = state[5];
  const double roll = state[6];
  const double across = q * std::sin(roll) + r * std::cos(roll);
  rates[6] = state[3] + std::tan(state[7]) * across;
  rates[7] = q * std::cos(roll) - r * std::sin(roll);
  return rates;
}

FlightState state_of(const Trim& trim) {
  FlightState state = FlightState::Zero();
  state.head<3>() = velocity_D(trim.speed_m_s, trim.alpha_rad, trim.beta_rad);
  state[6] = trim.roll_rad;
  state[7] = trim.pitch_rad;
  return state;
}

std::optional<Trim> level_trim(const Airframe& airframe, double speed_m_s) {
  return TrimSearch(airframe, speed_m_s).solve();
}

}  // namespace cas::sim
