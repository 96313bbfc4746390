// SPDX-License-Identifier: BSD-3-Clause
#include "libsim/core/body/rigid_body.hpp"

#include <fmt/format.h>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "base/error.hpp"

namespace cas::sim {

namespace {

constexpr double kLongestSubstep = 1e-3;  // s

struct Derivative {
  Eigen::Vector3d v_W;
  Eigen::Vector3d a_W;
  Eigen::Vector4d q_dot;  // coefficient order of Eigen: x, y, z, w
  Eigen::Vector3d alpha_B;
  ForceSet::States x_dot;
};

struct Point {
  BodyState body;
  ForceSet::States x;
};

/// Everything that stays the same over a step.
struct Problem {
  const ForceSet& forces;
  const MassProperties& mass;
  const Environment& environment;
  const Wrench& held;
};

Eigen::Vector4d quaternion_rate(const Eigen::Quaterniond& q, const Eigen::Vector3d& w) {
  const Eigen::Vector3d u = q.vec();
  Eigen::Vector4d rate;
  rate.head<3>() = 0.5 * (q.w() * w + u.cross(w));
  rate[3] = -0.5 * u.dot(w);
  return rate;
}

void derivative(const Problem& problem, const Point& at, Derivative& out) {
  const auto& [forces, mass, environment, held] = problem;
  const BodyState& body = at.body;
  Wrench wrench = held;
  forces.evaluate(body, environment, at.x, out.x_dot, wrench);
  const Eigen::Vector3d h_B = mass.inertia_B() * body.w_WB_B;
  out.v_W = body.v_WB;
  out.a_W = body.q_WB * wrench.force_B / mass.mass_kg() + environment.gravity_W;
  out.q_dot = quaternion_rate(body.q_WB, body.w_WB_B);
  out.alpha_B = mass.inertia_inverse_B() * (wrench.torque_B - body.w_WB_B.cross(h_B));
}

/// to = from + h * slope
void advance(const Point& from, const Derivative& slope, double h, std::size_t states, Point& to) {
  to.body.p_WB = from.body.p_WB + h * slope.v_W;
  to.body.v_WB = from.body.v_WB + h * slope.a_W;
  to.body.q_WB.coeffs() = from.body.q_WB.coeffs() + h * slope.q_dot;
  to.body.w_WB_B = from.body.w_WB_B + h * slope.alpha_B;
  for (std::size_t i = 0; i < states; ++i) to.x[i] = from.x[i] + h * slope.x_dot[i];
}

/// sum += weight * slope
void accumulate(const Derivative& slope, double weight, std::size_t states, Derivative& sum) {
  sum.v_W += weight * slope.v_W;
  sum.a_W += weight * slope.a_W;
  sum.q_dot += weight * slope.q_dot;
  sum.alpha_B += weight * slope.alpha_B;
  for (std::size_t i = 0; i < states; ++i) sum.x_dot[i] += weight * slope.x_dot[i];
}

void rk4_step(const Problem& problem, double h, Point& point) {
  const std::size_t states = problem.forces.state_count();
  Point stage = point;
  Derivative slope;
  Derivative sum;
  derivative(problem, point, sum);
  advance(point, sum, 0.5 * h, states, stage);
  derivative(problem, stage, slope);
  accumulate(slope, 2.0, states, sum);
  advance(point, slope, 0.5 * h, states, stage);
  derivative(problem, stage, slope);
  accumulate(slope, 2.0, states, sum);
  advance(point, slope, h, states, stage);
  derivative(problem, stage, slope);
  accumulate(slope, 1.0, states, sum);
  advance(point, sum, h / 6.0, states, point);
  point.body.q_WB.normalize();
}

}  // namespace

MassProperties::MassProperties(double mass_kg, const Eigen::Matrix3d& inertia_B)
    : mass_kg_(mass_kg), inertia_B_(inertia_B), inertia_inverse_B_(inertia_B.inverse()) {}

void ForceSet::add(const ForceModel& model) {
  const auto count = static_cast<std::size_t>(std::max(0, model.state_count()));
  if (model_count_ == kMaxModels || count > ForceModel::kMaxStates ||
      state_count_ + count > kMaxStates) {
    throw base::ConfigError(
        fmt::format("a vehicle takes at most {} force models with {} states each and {} in all",
                    kMaxModels, ForceModel::kMaxStates, kMaxStates));
  }
  models_[model_count_++] = {&model, state_count_, count};
  state_count_ += count;
}

void ForceSet::reset_states() {
  for (std::size_t i = 0; i < model_count_; ++i) {
    const Entry& entry = models_[i];
    entry.model->initial_states({states_.data() + entry.first, entry.count});
  }
}

void ForceSet::evaluate(const BodyState& body, const Environment& environment, const States& x,
                        States& x_dot, Wrench& wrench) const {
  for (std::size_t i = 0; i < model_count_; ++i) {
    const Entry& entry = models_[i];
    entry.model->evaluate(body, environment, {x.data() + entry.first, entry.count},
                          {x_dot.data() + entry.first, entry.count}, wrench);
  }
}

void ForceSet::limit() {
  for (std::size_t i = 0; i < model_count_; ++i) {
    const Entry& entry = models_[i];
    entry.model->limit({states_.data() + entry.first, entry.count});
  }
}

std::span<const double> ForceSet::states_of(const ForceModel& model) const {
  for (std::size_t i = 0; i < model_count_; ++i) {
    if (models_[i].model == &model) return {states_.data() + models_[i].first, models_[i].count};
  }
  return {};
}

int substeps(double dt) {
  return std::max(1, static_cast<int>(std::ceil(dt / kLongestSubstep - 1e-9)));
}

void integrate_free(BodyState& body, ForceSet& forces, const MassProperties& mass,
                    const Environment& environment, const Wrench& held, double dt) {
  const Problem problem{forces, mass, environment, held};
  const int parts = substeps(dt);
  Point point{body, forces.states()};
  for (int i = 0; i < parts; ++i) {
    rk4_step(problem, dt / parts, point);
    forces.states() = point.x;
    forces.limit();
    point.x = forces.states();
  }
  body = point.body;
}

Wrench integrate_forces(const BodyState& body, ForceSet& forces, const Environment& environment,
                        const Wrench& held, double dt) {
  // Simpson's rule on the wrench, RK4 on the states: the weights are the same.
  const std::size_t states = forces.state_count();
  const ForceSet::States x0 = forces.states();
  ForceSet::States x = x0;
  ForceSet::States sum{};
  Wrench mean;
  constexpr std::array<double, 4> kWeights{1.0 / 6, 1.0 / 3, 1.0 / 3, 1.0 / 6};
  const std::array<double, 4> next{0.5 * dt, 0.5 * dt, dt, 0.0};
  for (std::size_t stage = 0; stage < 4; ++stage) {
    Wrench wrench;
    ForceSet::States x_dot;
    forces.evaluate(body, environment, x, x_dot, wrench);
    mean.force_B += kWeights[stage] * wrench.force_B;
    mean.torque_B += kWeights[stage] * wrench.torque_B;
    for (std::size_t i = 0; i < states; ++i) {
      sum[i] += kWeights[stage] * x_dot[i];
      x[i] = x0[i] + next[stage] * x_dot[i];
    }
  }
  for (std::size_t i = 0; i < states; ++i) forces.states()[i] = x0[i] + dt * sum[i];
  forces.limit();
  mean.force_B += held.force_B;
  mean.torque_B += held.torque_B;
  return mean;
}

}  // namespace cas::sim
