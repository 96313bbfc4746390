// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <array>
#include <filesystem>
#include <vector>

namespace cas::sim {

/// Air velocity on a grid of places, the same at all times.
class WindGrid {
 public:
  /// Reads a CSV file with the columns x_m, y_m, z_m (east, north, up in W) and u_m_s, v_m_s,
  /// w_m_s (the same axes): one line for each combination of the values of x, y and z, in any
  /// order. The values need not be evenly spaced; one value makes the field constant along that
  /// axis. @throws base::ConfigError "FILE:LINE: ..."
  static WindGrid load(const std::filesystem::path& file);

  /// Air velocity in W, linear between the places; outside, that of the nearest face.
  Eigen::Vector3d at(const Eigen::Vector3d& p_W) const;

 private:
  std::size_t index(const std::array<std::size_t, 3>& cell) const;

  std::array<std::vector<double>, 3> axes_;  // rising
  std::vector<Eigen::Vector3d> wind_W_;      // x runs fastest
};

}  // namespace cas::sim
