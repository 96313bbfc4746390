// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <span>

#include "libsim/api/world.hpp"
#include "libsim/core/export.hpp"

namespace cas::sim {

/// Mass, kg, and full inertia tensor about the centre of gravity in the axes of B, kg m^2.
class CAS_SIM_EXPORT MassProperties {
 public:
  MassProperties() : MassProperties(1.0, Eigen::Matrix3d::Identity()) {}
  MassProperties(double mass_kg, const Eigen::Matrix3d& inertia_B);

  double mass_kg() const { return mass_kg_; }
  const Eigen::Matrix3d& inertia_B() const { return inertia_B_; }
  /// 1/(kg m^2)
  const Eigen::Matrix3d& inertia_inverse_B() const { return inertia_inverse_B_; }
  /// The same shape of another mass: the inertia scales with it.
  MassProperties scaled(double factor) const { return {mass_kg_ * factor, inertia_B_ * factor}; }

 private:
  double mass_kg_;
  Eigen::Matrix3d inertia_B_;
  Eigen::Matrix3d inertia_inverse_B_;
};

/// The force models of one vehicle and their internal states, in one block without allocation.
class CAS_SIM_EXPORT ForceSet {
 public:
  static constexpr std::size_t kMaxModels = 8;
  static constexpr std::size_t kMaxStates = ForceModel::kMaxStates;
  using States = std::array<double, kMaxStates>;

  /// @throws base::ConfigError when there are too many models or states
  void add(const ForceModel& model);
  /// Sets every state to its model's start.
  void reset_states();

  /// Adds every model's wrench for the states `x` and writes their derivatives.
  void evaluate(const BodyState& body, const Environment& environment, const States& x,
                States& x_dot, Wrench& wrench) const;
  /// Clamps the states to the limits of their models; after each integration step.
  void limit();

  std::size_t state_count() const { return state_count_; }
  States& states() { return states_; }
  const States& states() const { return states_; }
  /// States of one model; empty when it is not in this set.
  std::span<const double> states_of(const ForceModel& model) const;

 private:
  struct Entry {
    const ForceModel* model = nullptr;
    std::size_t first = 0;
    std::size_t count = 0;
  };
  std::array<Entry, kMaxModels> models_{};
  std::size_t model_count_ = 0;
  std::size_t state_count_ = 0;
  States states_{};
};

/// Integrates a free rigid body and its force models' states by the classical fourth-order
/// Runge-Kutta method on position, velocity, attitude quaternion, body rates and model states.
///
/// Newton-Euler about the centre of gravity:
///   m v_dot = R_WB f_B + m g_W,   I w_dot = t_B - w x (I w),   q_dot = q (0, w) / 2.
/// Forces are evaluated at every stage; environment and `held` wrench are constant over the step.
/// Steps longer than 1 ms are divided, so that accuracy does not depend on the step asked for.
/// The accelerations in `body` stay as they are.
CAS_SIM_EXPORT void integrate_free(BodyState& body, ForceSet& forces, const MassProperties& mass,
                                   const Environment& environment, const Wrench& held, double dt);

/// Integrates only the states of the force models while the body is held still. Returns their mean
/// wrench over `dt` (s) plus `held`, for the contact solver to apply.
CAS_SIM_EXPORT Wrench integrate_forces(const BodyState& body, ForceSet& forces,
                                       const Environment& environment, const Wrench& held,
                                       double dt);

/// Number of equal parts, each at most 1 ms, that a step is integrated in.
CAS_SIM_EXPORT int substeps(double dt);

}  // namespace cas::sim
