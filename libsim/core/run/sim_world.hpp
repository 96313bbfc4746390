// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <deque>
#include <memory>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "libsim/api/world.hpp"
#include "libsim/core/body/floor.hpp"
#include "libsim/core/body/rest_detector.hpp"
#include "libsim/core/body/rigid_body.hpp"
#include "libsim/core/body/world_model.hpp"
#include "libsim/core/export.hpp"
#include "libsim/core/load/model_loader.hpp"
#include "libsim/core/load/sim_config.hpp"
#include "libsim/core/ode/contact_solver.hpp"
#include "libsim/core/rays/ray_scene.hpp"

namespace cas::sim {

/// The world that plugins see: bodies, objects around them, and the step.
///
/// A vehicle is in one of three modes, chosen in each step from geometry alone:
///   free     nothing within reach: our RK4; ODE is not asked
///   contact  touching the world or another vehicle: ODE's stepper with contact joints
///   held     at rest under unchanged forces: stands still
/// Position, velocity and forces pass from one to the other unchanged. Moving obstacles follow
/// their path whatever they meet; a body that they touch is in contact and never held.
class CAS_SIM_EXPORT SimWorld final : public World {
 public:
  SimWorld(const WorldModel& model, const base::LocalProjection& projection, double decimal_year,
           Integrator integrator);
  ~SimWorld() override;

  /// Before start(). The lowest point of the vehicle is `pose.z_m` above z = 0.
  VehicleId add_vehicle(const VehicleModel& model, const StartPose& pose);
  void add_force_model(VehicleId vehicle, ForceModel& model);
  /// Before start(): makes it build what casts many rays quickly. ODE casts them otherwise.
  void expect_rays() { expects_rays_ = true; }
  /// Lets vehicles that start on a surface settle on it, then sets time zero.
  void start();
  /// The state that start() left.
  void reset();
  /// Advances everything by `dt` s.
  void advance(double dt);
  /// Distance along a ray to the first surface that never moves, m; nullopt: none within the range.
  /// @param direction_W  unit
  std::optional<double> ray_to_statics(const Eigen::Vector3d& origin_W,
                                       const Eigen::Vector3d& direction_W, double range_m) const;
  /// Whether the vehicle has fallen out of the world: nothing is left below it.
  bool is_below_everything(VehicleId vehicle) const;

  const BodyState& state(VehicleId vehicle) const override { return at(vehicle).state; }
  std::span<const double> states_of(const ForceModel& model) const override;
  const Environment& environment(VehicleId vehicle) const override {
    return at(vehicle).environment;
  }
  double mass_kg(VehicleId vehicle) const override { return at(vehicle).mass.mass_kg(); }
  bool in_contact(VehicleId vehicle) const override { return at(vehicle).touching; }
  const base::LocalProjection& projection() const override { return projection_; }
  double decimal_year() const override { return decimal_year_; }
  std::optional<double> ray_distance(VehicleId vehicle, const Eigen::Vector3d& origin_W,
                                     const Eigen::Vector3d& direction_W,
                                     double range_m) const override;
  void cast(VehicleId vehicle, std::span<const Eigen::Vector3d> origins_W,
            std::span<const Eigen::Vector3d> directions_W, double range_m,
            std::span<RayHit> hits) const override;
  bool disc_touches(VehicleId vehicle, const Eigen::Vector3d& centre_B,
                    const Eigen::Vector3d& axis_B, double radius_m) const override;

  std::optional<Eigen::Vector3d> magnetic_field_W() const override { return magnetic_field_W_; }
  base::Atmosphere atmosphere() const override { return atmosphere_; }

  void set_wind_W(VehicleId vehicle, const Eigen::Vector3d& wind_W) override;
  void set_wind_gradient_W(VehicleId vehicle, const Eigen::Matrix3d& gradient_W) override;
  void add_wrench(VehicleId vehicle, const Wrench& wrench) override;
  void scale_mass(VehicleId vehicle, double factor) override;

 private:
  enum class Mode { kFree, kContact, kHeld };

  struct VehicleBody {
    std::vector<Shape> shapes;
    BodyState start;
    MassProperties start_mass;
    BodyState state;
    MassProperties mass;
    ForceSet forces;
    Environment environment;
    Wrench extra;    // of plugins, for the coming step
    Wrench applied;  // mean over the part step, in contact
    bool has_applied = false;
    bool touching = false;
    bool beside_obstacle = false;                          // touches one that moves
    Eigen::Vector3d v_before_W = Eigen::Vector3d::Zero();  // at the start of the step
    Eigen::Vector3d w_before_B = Eigen::Vector3d::Zero();
    Mode mode = Mode::kFree;
    RestDetector rest;
    std::optional<RestDetector> rest_at_start;  // of a vehicle that starts at rest on something
  };

  VehicleBody& at(VehicleId vehicle) { return vehicles_[static_cast<std::size_t>(vehicle)]; }
  const VehicleBody& at(VehicleId vehicle) const {
    return vehicles_[static_cast<std::size_t>(vehicle)];
  }
  void set_to_start(VehicleBody& body);
  void settle(std::size_t index);

  void advance_part(double h);
  void choose_modes(double h);
  bool stays_held(VehicleBody& body, double h);
  void collide_pairs();
  void push(std::size_t index, double h);
  void take_contact_result(std::size_t index, double h);
  void hold_what_rests();
  void place_obstacles();
  void collide_obstacles();
  void wake_beside_obstacles();
  void refresh_environment(VehicleBody& body);

  void prepare_rays();
  std::optional<RayHit> first_hit(std::size_t vehicle, const Eigen::Vector3d& origin_W,
                                  const Eigen::Vector3d& direction_W, double range_m) const;
  std::optional<RayHit> hit_of_statics(const Eigen::Vector3d& origin_W,
                                       const Eigen::Vector3d& direction_W, double range_m) const;
  std::optional<RayHit> hit_of_body(std::size_t body, const BodyState& state,
                                    const Eigen::Vector3d& origin_W,
                                    const Eigen::Vector3d& direction_W, double range_m) const;

  base::LocalProjection projection_;
  double decimal_year_;
  Integrator integrator_;
  Eigen::Vector3d gravity_W_;
  Eigen::Vector3d wind_W_;
  std::optional<Eigen::Vector3d> magnetic_field_W_;
  base::Atmosphere atmosphere_;
  Floor floor_;
  struct Obstacle {
    MovingObstacle model;
    std::size_t body = 0;  // number in the solver, behind the vehicles'
    BodyState state;
  };

  /// The world for many rays. What moves has a scene of its own, into whose frame the rays are
  /// turned: nothing is rebuilt in a step.
  struct Rays {
    std::unique_ptr<RayScene> statics;
    std::vector<std::unique_ptr<RayScene>> bodies;  // numbered as in the solver
  };

  std::unique_ptr<ContactSolver> solver_;
  std::vector<Shape> statics_;
  std::shared_ptr<const Terrain> terrain_;  // null: none
  bool expects_rays_ = false;
  std::optional<Rays> rays_;  // nullopt: ODE casts them
  std::vector<Obstacle> obstacles_;
  base::Duration elapsed_{};  // since time zero, at the start of the part step
  std::deque<VehicleBody> vehicles_;
  std::vector<std::pair<std::size_t, std::size_t>> touching_pairs_;  // of the part step
};

}  // namespace cas::sim
