// SPDX-License-Identifier: BSD-3-Clause
#include "libsim/core/load/world_loader.hpp"

namespace cas::sim {

WorldModel load_world(const WorldConfig& config) {
  if (config.sdf) return load_sdf_world(*config.sdf, config.model_path, config.missing);
  WorldModel model;
  model.gravity_W = {0, 0, -config.gravity_m_s2};
  if (config.ground) {
    model.statics.push_back({.name = "ground",
                             .geometry = Plane{},
                             .pose = Eigen::Isometry3d::Identity(),
                             .surface = {}});
  }
  return model;
}

}  // namespace cas::sim
