// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/config/config.hpp"
#include "base/config/model_body.hpp"
#include "base/config/vehicle.hpp"

namespace cas::base {

/// Keys of a rotor's coefficients that must be there: in the vehicle file's block `rotor`, at the
/// rotor itself, or in the model's motor plugin.
inline constexpr std::array<std::string_view, 13> kRotorKeys{
    "thrust_coefficient",    "torque_coefficient",
    "omega_max_rad_s",       "omega_idle_rad_s",
    "time_constant_up_s",    "time_constant_down_s",
    "inertia_kg_m2",         "radius_m",
    "drag_coefficient",      "rolling_moment_coefficient",
    "zero_thrust_speed_m_s", "reference_density_kg_m3",
    "ground_effect"};

/// The value of a key that must be above zero. @throws ConfigError
double positive_value(const ConfigNode& node, std::string_view key);
/// A direction, as a unit vector. @throws ConfigError where it is zero
Eigen::Vector3d unit_vector(const ConfigNode& node);

/// Holds the vehicle file's word against the model's, or takes the model's where the file has none.
class ModelMatch {
 public:
  ModelMatch(const ConfigNode& node, std::optional<ModelBody> body)
      : node_(node), body_(std::move(body)) {}

  bool has_model() const { return body_.has_value(); }
  bool has_mass() const { return body_ && body_->mass_kg > 0; }
  double mass_kg() const;
  Eigen::Vector3d inertia_kg_m2() const;

  /// The link that carries a rotor: the one that `link` names, else rotor_N (from rotor_0 on where
  /// there is one), else the turning link nearest to the place that the file gives. Nothing where
  /// the model has no such link.
  const ModelLink* link_of(const ConfigNode& item, int number) const;
  /// The motor plugin of that link, or nothing.
  const ModelMotor* motor_of(const ModelLink* link) const {
    return link != nullptr ? body_->motor_of(*link) : nullptr;
  }
  void place(const ConfigNode& item, const ModelLink* link, Rotor& rotor) const;

  /// Settles the links that turn and are no rotor of the list: one that weighs as much as a rotor
  /// of the list was forgotten; others count as fixed, with a warning.
  /// @param taken  each rotor's link, or nothing
  void settle_others(const ConfigNode& rotors, const std::vector<const ModelLink*>& taken,
                     Vehicle& vehicle) const;

 private:
  [[noreturn]] void differ(const ConfigNode& key, const std::string& here, const std::string& place,
                           const std::string& there, const std::string& what) const;
  void check_place(const ConfigNode& key, const ModelLink& link, const Eigen::Vector3d& p_B) const;
  void check_axis(const ConfigNode& key, const ModelLink& link, const Eigen::Vector3d& axis) const;
  const ModelLink* nearest(const Eigen::Vector3d& p_B) const;
  std::string turning_names() const;

  ConfigNode node_;
  std::optional<ModelBody> body_;
};

}  // namespace cas::base
