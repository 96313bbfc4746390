// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <memory>

#include "tests/libsim/support/crate.hpp"

namespace cas::sim::test {

/// Flat ground of triangles; its grid is not in line with the axes.
inline WorldModel ground_of_triangles(double cell_m, double friction = 1.0) {
  const int n = static_cast<int>(6.0 / cell_m);
  auto mesh = std::make_shared<TriangleMesh>();
  for (int j = 0; j <= n; ++j) {
    for (int i = 0; i <= n; ++i) {
      mesh->vertices.emplace_back(-3 + i * cell_m + 0.013, -3 + j * cell_m + 0.007, 0);
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

}  // namespace cas::sim::test
