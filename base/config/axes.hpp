// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <string>

#include "base/config/config.hpp"

namespace cas::base {

/// Three numbers, or one for all three axes.
inline Eigen::Vector3d parse_axes(const ConfigNode& node) {
  if (node.is_scalar()) return Eigen::Vector3d::Constant(node.as<double>());
  return node.as<Eigen::Vector3d>();
}

/// parse_axes of an optional key; zero when it is missing.
inline Eigen::Vector3d get_axes(const ConfigNode& node, const std::string& key) {
  const auto child = node.find(key);
  return child ? parse_axes(*child) : Eigen::Vector3d::Zero();
}

}  // namespace cas::base
