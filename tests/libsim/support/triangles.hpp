// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <memory>

#include "tests/libsim/support/crate.hpp"

namespace cas::sim::test {

/// Ground of triangles; its grid is not in line with the axes.
/// @param height_m  above a place (x, y), m
template <class Height>
WorldModel ground_of_triangles(double cell_m, double friction, Height height_m) {
  const int n = static_cast<int>(6.0 / cell_m);
  auto mesh = std::make_shared<TriangleMesh>();
  for (int j = 0; j <= n; ++j) {
    for (int i = 0; i <= n; ++i) {
      const double x = -3 + i * cell_m + 0.013;
      const double y = -3 + j * cell_m + 0.007;
      mesh->vertices.emplace_back(x, y, height_m(x, y));
    }
  }
  const auto corner = [n](int i, int j) { return static_cast<std::uint32_t>(j * (n + 1) + i); };
  for (int j = 0; j < n; ++j) {
    for (int i = 0; i < n; ++i) {
      mesh->triangles.push_back({corner(i, j), corner(i + 1, j), corner(i + 1, j + 1)});
      mesh->triangles.push_back({corner(i, j), corner(i + 1, j + 1), corner(i, j + 1)});
    }
  }
  WorldModel model;
  model.gravity_W = {0, 0, -kGravity};
  model.statics.push_back(standing("ground", Mesh{mesh}, Eigen::Vector3d::Zero(), friction));
  return model;
}

/// The same, flat.
inline WorldModel ground_of_triangles(double cell_m, double friction = 1.0) {
  return ground_of_triangles(cell_m, friction, [](double, double) { return 0.0; });
}

}  // namespace cas::sim::test
