// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "libsim/core/run/sim_world.hpp"

namespace cas::sim::test {

inline constexpr double kGravity = 9.80665;              // m/s^2
inline constexpr double kCrateMass = 1.5;                // kg
inline const Eigen::Vector3d kCrateSize{0.4, 0.4, 0.1};  // m

inline constexpr VehicleId kVehicle{0};
inline constexpr double kStep_s = 1e-3;

/// Noise of the accelerometer of the quietest real sensor set (pixhawk_icm42605), m/s^2:
/// 6.9e-4 m/s^2/sqrt(Hz) at 500 Hz.
inline constexpr double kSensorStd = 0.015;

/// A vehicle that is a flat box of even density.
inline VehicleModel crate(const Eigen::Vector3d& size = kCrateSize, double mass = kCrateMass) {
  const Eigen::Vector3d s = size.cwiseAbs2();
  VehicleModel model;
  model.name = "crate";
  const Eigen::Vector3d inertia =
      mass / 12.0 * Eigen::Vector3d(s.y() + s.z(), s.x() + s.z(), s.x() + s.y());
  model.mass = MassProperties(mass, inertia.asDiagonal());
  model.shapes.push_back({.name = "crate",
                          .geometry = Box{size},
                          .pose = Eigen::Isometry3d::Identity(),
                          .surface = {}});
  return model;
}

inline Shape standing(const std::string& name, const Geometry& geometry,
                      const Eigen::Vector3d& at = Eigen::Vector3d::Zero(), double friction = 1.0) {
  Shape shape{.name = name,
              .geometry = geometry,
              .pose = Eigen::Isometry3d::Identity(),
              .surface = {.friction = friction}};
  shape.pose.translation() = at;
  return shape;
}

/// Flat ground under gravity.
inline WorldModel flat_world(double friction = 1.0) {
  WorldModel model;
  model.gravity_W = {0, 0, -kGravity};
  model.statics.push_back(standing("ground", Plane{}, Eigen::Vector3d::Zero(), friction));
  return model;
}

inline std::unique_ptr<SimWorld> make_world(const WorldModel& model,
                                            Integrator integrator = Integrator::kRk4) {
  return std::make_unique<SimWorld>(
      model, base::LocalProjection({.lat_deg = 47, .lon_deg = 8, .alt_m = 488}), 2026.5,
      integrator);
}

/// The world with one vehicle in it, begun.
inline std::unique_ptr<SimWorld> started(std::unique_ptr<SimWorld> world, const VehicleModel& model,
                                         const StartPose& pose) {
  world->add_vehicle(model, pose);
  world->start();
  return world;
}

/// Total of tilt away from level, rad.
inline double tilt(const BodyState& state) {
  return std::acos(std::clamp((state.q_WB * Eigen::Vector3d::UnitZ()).z(), -1.0, 1.0));
}

}  // namespace cas::sim::test
