// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "base/earth/atmosphere.hpp"
#include "base/earth/geodesy.hpp"
#include "base/time/clock.hpp"
#include "libsim/core/body/obstacle_path.hpp"
#include "libsim/core/body/shape.hpp"

namespace cas::sim {

class Terrain;

/// A world without its vehicles: its objects and its environment.
struct WorldModel {
  std::string name;
  Eigen::Vector3d gravity_W = Eigen::Vector3d::Zero();
  Eigen::Vector3d wind_W = Eigen::Vector3d::Zero();
  std::vector<Shape> statics;  ///< poses in W
  std::vector<MovingObstacle> moving;
  std::shared_ptr<const Terrain> terrain;  ///< null: none
  std::optional<base::Geodetic> home;
  std::optional<base::Duration> step;
  std::optional<double> real_time_factor;
  std::optional<Eigen::Vector3d> magnetic_field_W;  ///< gauss; nullopt: the Earth's
  base::Atmosphere atmosphere;
  std::vector<std::string> warnings;  ///< one sentence for each thing that is not supported
};

}  // namespace cas::sim
