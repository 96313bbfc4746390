// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>

#include "base/error.hpp"
#include "libsim/api/world.hpp"
#include "libsim/core/body/rigid_body.hpp"
#include "libsim/core/body/shape.hpp"
#include "libsim/core/export.hpp"

namespace cas::sim {

class Terrain;

/// A flat disc about z of its own axes D.
struct Disc {
  Eigen::Vector3d centre_W;  ///< m
  Eigen::Quaterniond q_WD;   ///< turns vectors from D into W
  double radius_m;
};

/// ODE has given up: a mass, a size or a motion is out of all proportion. `what()` has its words.
/// The solver that threw it may only be destroyed; its memory is lost.
class CAS_SIM_EXPORT SolverFailure : public base::ConfigError {
 public:
  using base::ConfigError::ConfigError;
};

/// Contacts, world geometry and ray casts by the Open Dynamics Engine; nothing else includes it.
///
/// A contact is a spring and damper along the normal (so that a landing is felt as a landing, not
/// as one infinite sample; contact_law.hpp) and Coulomb friction in the plane, solved exactly by
/// ODE's Dantzig solver: a resting body does not creep. ODE limits friction by a box; its first
/// side is laid along the direction in which the contact would slip, which makes friction the same
/// in every direction. Of many contacts the outermost carry the body, on uneven ground four that
/// stand for all (contact_patch.hpp, remembered_points.hpp); a plane replaces a flat mesh
/// (flat_ground.hpp). A body that has moved less than 20 um keeps its contacts. Restitution and
/// rolling friction are not modelled.
///
/// Per step: begin() -> place() and collide_*() for bodies that may touch -> apply() for those that
/// are touching() -> step() -> read().
class CAS_SIM_EXPORT ContactSolver {
 public:
  /// @param gravity_W  m/s^2
  explicit ContactSolver(const Eigen::Vector3d& gravity_W);
  ~ContactSolver();
  ContactSolver(const ContactSolver&) = delete;
  ContactSolver& operator=(const ContactSolver&) = delete;

  /// Adds a shape of the world, in its place in W.
  void add_static(const Shape& shape);
  /// Lets bodies, discs and rays meet a terrain, too.
  void set_terrain(std::shared_ptr<const Terrain> terrain);
  /// Adds a vehicle; its shapes are about its centre of gravity in B. Bodies are numbered from 0 in
  /// the order in which they are added.
  void add_body(std::span<const Shape> shapes, const MassProperties& mass);
  /// Adds an obstacle that place() moves and nothing else; its velocity counts in its contacts.
  /// Numbered as the bodies are. @return its number
  std::size_t add_obstacle(std::span<const Shape> shapes);
  /// Gives a body another mass and inertia from the next step on.
  void set_mass(std::size_t body, const MassProperties& mass);

  /// True when the body's bounding sphere about `p_W` comes within reach of the static world.
  /// Cheap: no narrow phase.
  bool near_world(std::size_t body, const Eigen::Vector3d& p_W) const;
  /// True when the bounding spheres of two bodies overlap.
  bool near_each_other(std::size_t a, const Eigen::Vector3d& p_a_W, std::size_t b,
                       const Eigen::Vector3d& p_b_W) const;

  /// Forgets the contacts of the last step; the coming one takes `dt` s.
  void begin(double dt);
  /// Moves the body to a state.
  void place(std::size_t body, const BodyState& state);
  /// Finds the contacts of a placed body with the static world.
  void collide_world(std::size_t body);
  /// Finds the contacts between two placed bodies. @return whether there are any
  bool collide_bodies(std::size_t a, std::size_t b);
  /// True when the body has had a contact since begin().
  bool touching(std::size_t body) const;

  /// Force and moment about the centre of gravity for the coming step, and makes the body take
  /// part in it.
  void apply(std::size_t body, const Wrench& wrench);
  /// Steps the bodies that were given a wrench; gravity acts on them. @throws SolverFailure
  void step();
  /// Copies position, velocity, attitude and rates of the body.
  void read(std::size_t body, BodyState& state) const;

  /// The first surface of the static world along a ray (unit direction).
  std::optional<RayHit> ray_to_world(const Eigen::Vector3d& origin_W,
                                     const Eigen::Vector3d& direction_W, double range_m) const;
  /// The same to one body, which must have been placed when the ray comes near it.
  std::optional<RayHit> ray_to_body(std::size_t body, const Eigen::Vector3d& origin_W,
                                    const Eigen::Vector3d& direction_W, double range_m) const;
  /// True when a sphere comes within reach of the static world. Cheap, as near_world().
  bool world_within(const Eigen::Vector3d& p_W, double radius_m) const;
  /// Whether a disc touches the static world. Cheap where nothing is near.
  bool touches_world(const Disc& disc) const;
  /// The same for one body, which must have been placed when the disc comes near it.
  bool touches_body(std::size_t body, const Disc& disc) const;
  /// Height of a point over the static surface below it, m; infinite over nothing.
  double height_above_ground(const Eigen::Vector3d& p_W) const;
  /// Radius of the body's bounding sphere about its centre of gravity, m.
  double radius(std::size_t body) const;

  /// Messages of ODE since the program started, those of contacts that contradict each other.
  static std::uint64_t complaints();

  /// Seeds ODE's process-wide random numbers and forgets earlier contacts.
  void reset();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace cas::sim
