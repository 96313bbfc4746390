// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string_view>

#include "base/config/config.hpp"
#include "base/time/clock.hpp"
#include "plugins/fault/expression.hpp"

namespace cas::hils {

/// Motion of the vehicle, true or estimated. Positions count from the start: north, east, up.
struct Motion {
  Eigen::Vector3d p_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d v_m_s = Eigen::Vector3d::Zero();
  Eigen::Vector3d rpy_rad = Eigen::Vector3d::Zero();  ///< N to D: roll, pitch, yaw
};

/// Quantities that conditions of a scenario can name, in their units.
sim::Facts facts_of(base::SimTime now, const Motion& motion, bool armed, std::string_view phase);

/// A condition of a scenario, on the vehicle's own estimate or on the truth.
struct Condition {
  sim::Expression expression;
  bool on_truth = false;
};

/// Reads `key` ("altitude > 2 and phase == hold") and `of: estimate | truth` of a map.
/// @return nullopt when the key is not there. @throws base::ConfigError
std::optional<Condition> parse_condition(const base::ConfigNode& node, std::string_view key);

}  // namespace cas::hils
