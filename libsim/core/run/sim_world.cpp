// SPDX-License-Identifier: BSD-3-Clause
#include "libsim/core/run/sim_world.hpp"

#include <algorithm>
#include <cmath>

#include "base/error.hpp"
#include "base/os/log.hpp"
#include "libsim/core/run/start.hpp"
#include "libsim/core/terrain/terrain.hpp"

namespace cas::sim {

namespace {

// Settling before time zero.
constexpr double kSettleStep = 1e-3;      // s
constexpr int kSettleSteps = 2000;        // at most
constexpr double kSettleReach = 1e-3;     // m: a start this near to a surface is a start on it
constexpr double kSettleDistance = 0.01;  // m: a body that moves farther is not at rest

/// Distance of a point from a ray's segment.
double distance_to_segment(const Eigen::Vector3d& p, const Eigen::Vector3d& origin,
                           const Eigen::Vector3d& direction, double range) {
  const double along = std::clamp(direction.dot(p - origin), 0.0, range);
  return (origin + along * direction - p).norm();
}

}  // namespace

SimWorld::SimWorld(const WorldModel& model, const base::LocalProjection& projection,
                   double decimal_year, Integrator integrator)
    : projection_(projection),
      decimal_year_(decimal_year),
      integrator_(integrator),
      gravity_W_(model.gravity_W),
      wind_W_(model.wind_W),
      magnetic_field_W_(model.magnetic_field_W),
      atmosphere_(model.atmosphere),
      floor_(model.statics),
      solver_(std::make_unique<ContactSolver>(model.gravity_W)),
      statics_(model.statics),
      terrain_(model.terrain) {
  for (const Shape& shape : model.statics) solver_->add_static(shape);
  if (terrain_) solver_->set_terrain(terrain_);
  for (const MovingObstacle& obstacle : model.moving) {
    obstacles_.push_back({.model = obstacle, .body = 0, .state = obstacle.path.at(0)});
  }
}

SimWorld::~SimWorld() = default;

VehicleId SimWorld::add_vehicle(const VehicleModel& model, const StartPose& pose) {
  solver_->add_body(model.shapes, model.mass);
  const std::size_t index = vehicles_.size();
  VehicleBody body{
      .shapes = model.shapes,
      .start = start_state(model, pose),
      .start_mass = model.mass,
      .state = {},
      .mass = model.mass,
      .forces = {},
      .environment = {},
      .extra = {},
      .applied = {},
      .rest = RestDetector(model.mass.mass_kg() * gravity_W_.norm(), solver_->radius(index)),
      .rest_at_start = std::nullopt};
  vehicles_.push_back(std::move(body));
  set_to_start(vehicles_.back());
  return static_cast<VehicleId>(index);
}

void SimWorld::add_force_model(VehicleId vehicle, ForceModel& model) {
  at(vehicle).forces.add(model);
  at(vehicle).forces.reset_states();
}

void SimWorld::start() {
  solver_->reset();
  touching_pairs_.reserve(vehicles_.size() * vehicles_.size());
  for (Obstacle& obstacle : obstacles_)
    obstacle.body = solver_->add_obstacle(obstacle.model.shapes);
  for (std::size_t i = 0; i < vehicles_.size(); ++i) settle(i);
  if (expects_rays_) prepare_rays();
  reset();
}

void SimWorld::reset() {
  solver_->reset();
  elapsed_ = {};
  place_obstacles();
  for (std::size_t i = 0; i < vehicles_.size(); ++i) {
    vehicles_[i].mass = vehicles_[i].start_mass;
    solver_->set_mass(i, vehicles_[i].mass);
    set_to_start(vehicles_[i]);
  }
}

void SimWorld::set_to_start(VehicleBody& body) {
  body.state = body.start;
  body.forces.reset_states();
  body.environment.wind_W = wind_W_;
  body.environment.wind_gradient_W.reset();
  body.extra = {};
  body.touching = body.rest_at_start.has_value();
  body.mode = body.touching ? Mode::kHeld : Mode::kFree;
  body.rest.wake();
  if (body.rest_at_start) body.rest = *body.rest_at_start;
  refresh_environment(body);
}

/// Runs the contact solver on the vehicle alone, without its forces, until it rests.
void SimWorld::settle(std::size_t index) {
  VehicleBody& body = vehicles_[index];
  BodyState state = body.start;
  state.p_WB.z() -= kSettleReach;
  solver_->begin(kSettleStep);
  solver_->place(index, state);
  solver_->collide_world(index);
  if (!solver_->touching(index)) return;
  state = body.start;
  RestDetector rest = body.rest;
  for (int step = 0; step < kSettleSteps && !rest.at_rest(); ++step) {
    solver_->begin(kSettleStep);
    solver_->place(index, state);
    solver_->collide_world(index);
    solver_->apply(index, Wrench{});
    solver_->step();
    solver_->read(index, state);
    rest.update(state, Wrench{}, kSettleStep);
  }
  solver_->begin(kSettleStep);
  if (!rest.at_rest() || (state.p_WB - body.start.p_WB).norm() > kSettleDistance) return;
  body.start.p_WB = state.p_WB;
  body.start.q_WB = state.q_WB;
  body.rest_at_start = rest;
}

void SimWorld::advance(double dt) {
  for (VehicleBody& body : vehicles_) {
    body.v_before_W = body.state.v_WB;
    body.w_before_B = body.state.w_WB_B;
  }
  const int parts = substeps(dt);
  const base::Duration begin = elapsed_;
  for (int part = 0; part < parts; ++part) {
    elapsed_ = begin + base::from_seconds(dt * part / parts);
    advance_part(dt / parts);
  }
  elapsed_ = begin + base::from_seconds(dt);
  for (VehicleBody& body : vehicles_) {
    body.state.a_WB = (body.state.v_WB - body.v_before_W) / dt;
    body.state.alpha_WB_B = (body.state.w_WB_B - body.w_before_B) / dt;
    body.extra = {};
    refresh_environment(body);
    if (terrain_) terrain_->look_ahead(body.state.p_WB, body.state.v_WB);
  }
}

void SimWorld::advance_part(double h) {
  solver_->begin(h);
  place_obstacles();
  choose_modes(h);
  collide_pairs();
  collide_obstacles();

  bool pushed = false;
  for (std::size_t i = 0; i < vehicles_.size(); ++i) {
    VehicleBody& body = vehicles_[i];
    body.touching = body.mode == Mode::kHeld || solver_->touching(i);
    if (body.mode == Mode::kHeld) continue;
    if (body.touching || body.has_applied || integrator_ == Integrator::kOde) {
      body.mode = Mode::kContact;
      push(i, h);
      pushed = true;
    } else {
      body.mode = Mode::kFree;
      integrate_free(body.state, body.forces, body.mass, body.environment, body.extra, h);
    }
  }
  if (!pushed) return;

  solver_->step();
  for (std::size_t i = 0; i < vehicles_.size(); ++i) {
    if (vehicles_[i].mode == Mode::kContact) take_contact_result(i, h);
  }
  wake_beside_obstacles();
  hold_what_rests();
}

/// Finds the bodies that stay held and those that touch the static world.
void SimWorld::choose_modes(double h) {
  for (std::size_t i = 0; i < vehicles_.size(); ++i) {
    VehicleBody& body = vehicles_[i];
    body.has_applied = false;
    if (body.mode == Mode::kHeld && stays_held(body, h)) continue;
    body.mode = Mode::kFree;
    if (integrator_ != Integrator::kOde && !solver_->near_world(i, body.state.p_WB)) continue;
    solver_->place(i, body.state);
    solver_->collide_world(i);
  }
}

/// Advances the forces of a held body and tells whether they are still those it rests under.
bool SimWorld::stays_held(VehicleBody& body, double h) {
  body.applied = integrate_forces(body.state, body.forces, body.environment, body.extra, h);
  body.has_applied = true;
  if (body.rest.same(body.applied)) return true;
  body.rest.wake();
  return false;
}

/// Contacts between vehicles; one that hits a held vehicle wakes it.
void SimWorld::collide_pairs() {
  touching_pairs_.clear();
  const auto wake_when_hit = [this](std::size_t i) {
    VehicleBody& body = vehicles_[i];
    if (body.mode != Mode::kHeld || !solver_->touching(i)) return;
    body.mode = Mode::kContact;
    body.rest.wake();
    solver_->collide_world(i);
  };
  for (std::size_t i = 1; i < vehicles_.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      VehicleBody& a = vehicles_[i];
      VehicleBody& b = vehicles_[j];
      if (!solver_->near_each_other(i, a.state.p_WB, j, b.state.p_WB)) continue;
      if (a.mode == Mode::kHeld && b.mode == Mode::kHeld) continue;
      solver_->place(i, a.state);
      solver_->place(j, b.state);
      if (!solver_->collide_bodies(i, j)) continue;
      touching_pairs_.emplace_back(i, j);
      wake_when_hit(i);
      wake_when_hit(j);
    }
  }
}

/// Moves the obstacles to where they are now.
void SimWorld::place_obstacles() {
  for (Obstacle& obstacle : obstacles_) {
    obstacle.state = obstacle.model.path.at(base::to_seconds(elapsed_));
  }
}

/// Contacts of vehicles with obstacles; a held vehicle that is hit wakes.
void SimWorld::collide_obstacles() {
  if (obstacles_.empty()) return;
  for (std::size_t i = 0; i < vehicles_.size(); ++i) {
    VehicleBody& body = vehicles_[i];
    body.beside_obstacle = false;
    for (const Obstacle& obstacle : obstacles_) {
      if (!solver_->near_each_other(i, body.state.p_WB, obstacle.body, obstacle.state.p_WB))
        continue;
      solver_->place(i, body.state);
      solver_->place(obstacle.body, obstacle.state);
      if (!solver_->collide_bodies(i, obstacle.body)) continue;
      body.beside_obstacle = true;
      if (body.mode != Mode::kHeld) continue;
      body.mode = Mode::kContact;
      body.rest.wake();
      solver_->collide_world(i);
    }
  }
}

/// A body that touches an obstacle moves with it, so it never counts as resting.
void SimWorld::wake_beside_obstacles() {
  for (VehicleBody& body : vehicles_) {
    if (body.beside_obstacle) body.rest.wake();
  }
}

void SimWorld::push(std::size_t index, double h) {
  VehicleBody& body = vehicles_[index];
  if (!body.has_applied) {
    body.applied = integrate_forces(body.state, body.forces, body.environment, body.extra, h);
  }
  solver_->apply(index, body.applied);
}

void SimWorld::take_contact_result(std::size_t index, double h) {
  VehicleBody& body = vehicles_[index];
  solver_->read(index, body.state);
  if (!body.touching || integrator_ == Integrator::kOde) return;
  body.rest.update(body.state, body.applied, h);
}

/// Holds resting bodies; vehicles that touch each other rest together or not at all.
void SimWorld::hold_what_rests() {
  if (integrator_ == Integrator::kOde) return;
  bool changed = true;
  while (std::exchange(changed, false)) {
    for (const auto& [i, j] : touching_pairs_) {
      RestDetector& a = vehicles_[i].rest;
      RestDetector& b = vehicles_[j].rest;
      if (a.at_rest() == b.at_rest()) continue;
      (a.at_rest() ? a : b).almost();
      changed = true;
    }
  }
  for (VehicleBody& body : vehicles_) {
    if (body.mode != Mode::kContact || !body.rest.at_rest()) continue;
    body.mode = Mode::kHeld;
    body.state.v_WB.setZero();
    body.state.w_WB_B.setZero();
  }
}

void SimWorld::refresh_environment(VehicleBody& body) {
  Environment& environment = body.environment;
  environment.gravity_W = gravity_W_;
  environment.air_density_kg_m3 =
      atmosphere_.density_kg_m3(projection_.home().alt_m + body.state.p_WB.z());
  environment.height_above_ground_m = solver_->height_above_ground(body.state.p_WB);
}

std::span<const double> SimWorld::states_of(const ForceModel& model) const {
  for (const VehicleBody& body : vehicles_) {
    const std::span<const double> states = body.forces.states_of(model);
    if (states.data() != nullptr) return states;
  }
  return {};
}

std::optional<double> SimWorld::ray_distance(VehicleId vehicle, const Eigen::Vector3d& origin_W,
                                             const Eigen::Vector3d& direction_W,
                                             double range_m) const {
  const auto hit =
      first_hit(static_cast<std::size_t>(vehicle), origin_W, direction_W.normalized(), range_m);
  if (!hit) return std::nullopt;
  return hit->distance_m;
}

void SimWorld::cast(VehicleId vehicle, std::span<const Eigen::Vector3d> origins_W,
                    std::span<const Eigen::Vector3d> directions_W, double range_m,
                    std::span<RayHit> hits) const {
  for (std::size_t i = 0; i < hits.size(); ++i) {
    hits[i] = first_hit(static_cast<std::size_t>(vehicle), origins_W[i],
                        directions_W[i].normalized(), range_m)
                  .value_or(RayHit{});
  }
}

void SimWorld::prepare_rays() {
  Rays rays{.statics = make_ray_scene(statics_), .bodies = {}};
  if (!rays.statics) {
    base::log::warn(
        "rays are cast by ODE, at a fifth of the speed: libcas_sim_rays, which needs Embree, is "
        "not "
        "there");
    return;
  }
  for (const VehicleBody& body : vehicles_) rays.bodies.push_back(make_ray_scene(body.shapes));
  for (const Obstacle& obstacle : obstacles_) {
    rays.bodies.push_back(make_ray_scene(obstacle.model.shapes));
  }
  rays_ = std::move(rays);
}

/// The first surface along a ray that is not the vehicle's own. @param direction_W  unit
std::optional<RayHit> SimWorld::first_hit(std::size_t vehicle, const Eigen::Vector3d& origin_W,
                                          const Eigen::Vector3d& direction_W,
                                          double range_m) const {
  std::optional<RayHit> nearest = hit_of_statics(origin_W, direction_W, range_m);
  const auto look_at = [&](std::size_t body, const BodyState& state) {
    if (distance_to_segment(state.p_WB, origin_W, direction_W, range_m) > solver_->radius(body)) {
      return;
    }
    const auto hit = hit_of_body(body, state, origin_W, direction_W, range_m);
    if (hit && (!nearest || hit->distance_m < nearest->distance_m)) nearest = hit;
  };
  for (std::size_t i = 0; i < vehicles_.size(); ++i) {
    if (i != vehicle) look_at(i, vehicles_[i].state);
  }
  for (const Obstacle& obstacle : obstacles_) look_at(obstacle.body, obstacle.state);
  return nearest;
}

std::optional<RayHit> SimWorld::hit_of_statics(const Eigen::Vector3d& origin_W,
                                               const Eigen::Vector3d& direction_W,
                                               double range_m) const {
  if (!rays_) return solver_->ray_to_world(origin_W, direction_W, range_m);
  auto hit = rays_->statics->cast(origin_W, direction_W, range_m);
  if (!terrain_) return hit;
  const auto ground = terrain_->cast(origin_W, direction_W, hit ? hit->distance_m : range_m);
  return ground ? ground : hit;
}

std::optional<RayHit> SimWorld::hit_of_body(std::size_t body, const BodyState& state,
                                            const Eigen::Vector3d& origin_W,
                                            const Eigen::Vector3d& direction_W,
                                            double range_m) const {
  if (!rays_) {
    solver_->place(body, state);
    return solver_->ray_to_body(body, origin_W, direction_W, range_m);
  }
  const Eigen::Quaterniond q_BW = state.q_WB.conjugate();
  auto hit = rays_->bodies[body]->cast(q_BW * (origin_W - state.p_WB), q_BW * direction_W, range_m);
  if (hit) hit->normal = state.q_WB * hit->normal;
  return hit;
}

std::optional<double> SimWorld::ray_to_statics(const Eigen::Vector3d& origin_W,
                                               const Eigen::Vector3d& direction_W,
                                               double range_m) const {
  const auto hit = solver_->ray_to_world(origin_W, direction_W, range_m);
  if (!hit) return std::nullopt;
  return hit->distance_m;
}

bool SimWorld::is_below_everything(VehicleId vehicle) const {
  const Eigen::Vector3d& p_W = state(vehicle).p_WB;
  const double radius = solver_->radius(static_cast<std::size_t>(vehicle));
  if (terrain_) return terrain_->height_m(p_W.x(), p_W.y()) - p_W.z() > radius + Floor::kMargin_m;
  return floor_.is_above(p_W, radius);
}

bool SimWorld::disc_touches(VehicleId vehicle, const Eigen::Vector3d& centre_B,
                            const Eigen::Vector3d& axis_B, double radius_m) const {
  const BodyState& own = state(vehicle);
  // In the air nothing is within reach of it, however the vehicle turns.
  const bool alone = vehicles_.size() == 1 && obstacles_.empty();
  if (alone && !solver_->world_within(own.p_WB, centre_B.norm() + radius_m)) return false;
  const Eigen::Vector3d z = Eigen::Vector3d::UnitZ();
  const Disc disc{
      .centre_W = own.p_WB + own.q_WB * centre_B,
      .q_WD = axis_B == z ? own.q_WB : own.q_WB * Eigen::Quaterniond::FromTwoVectors(z, axis_B),
      .radius_m = radius_m};
  if (solver_->touches_world(disc)) return true;
  for (std::size_t i = 0; i < vehicles_.size(); ++i) {
    if (i == static_cast<std::size_t>(vehicle)) continue;
    const BodyState& other = vehicles_[i].state;
    if ((other.p_WB - disc.centre_W).norm() > solver_->radius(i) + radius_m) continue;
    solver_->place(i, other);
    if (solver_->touches_body(i, disc)) return true;
  }
  for (const Obstacle& obstacle : obstacles_) {
    if ((obstacle.state.p_WB - disc.centre_W).norm() > solver_->radius(obstacle.body) + radius_m) {
      continue;
    }
    solver_->place(obstacle.body, obstacle.state);
    if (solver_->touches_body(obstacle.body, disc)) return true;
  }
  return false;
}

void SimWorld::set_wind_W(VehicleId vehicle, const Eigen::Vector3d& wind_W) {
  at(vehicle).environment.wind_W = wind_W;
}

void SimWorld::set_wind_gradient_W(VehicleId vehicle, const Eigen::Matrix3d& gradient_W) {
  at(vehicle).environment.wind_gradient_W = gradient_W;
}

void SimWorld::add_wrench(VehicleId vehicle, const Wrench& wrench) {
  at(vehicle).extra.force_B += wrench.force_B;
  at(vehicle).extra.torque_B += wrench.torque_B;
}

void SimWorld::scale_mass(VehicleId vehicle, double factor) {
  if (!(factor > 0)) throw base::ConfigError("mass can only be scaled by a positive factor");
  VehicleBody& body = at(vehicle);
  const MassProperties mass = body.start_mass.scaled(factor);
  if (mass.mass_kg() == body.mass.mass_kg()) return;  // a vehicle at rest is not woken for nothing
  body.mass = mass;
  solver_->set_mass(static_cast<std::size_t>(vehicle), body.mass);
  body.rest.wake();
  if (body.mode == Mode::kHeld) body.mode = Mode::kContact;
}

}  // namespace cas::sim
