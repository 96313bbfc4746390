// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>

#include "base/earth/atmosphere.hpp"
#include "base/earth/geodesy.hpp"

namespace cas::sim {

/// Index of a vehicle in the world, from 0.
enum class VehicleId : std::uint32_t {};

/// Motion of a vehicle's centre of gravity.
struct BodyState {
  Eigen::Vector3d p_WB = Eigen::Vector3d::Zero();            ///< position in W, m
  Eigen::Vector3d v_WB = Eigen::Vector3d::Zero();            ///< velocity in W, m/s
  Eigen::Quaterniond q_WB = Eigen::Quaterniond::Identity();  ///< turns vectors from B into W
  Eigen::Vector3d w_WB_B = Eigen::Vector3d::Zero();          ///< angular velocity in B, rad/s
  /// Mean acceleration over the last step in W, m/s^2; gravity included.
  Eigen::Vector3d a_WB = Eigen::Vector3d::Zero();
  /// Mean angular acceleration over the last step in B, rad/s^2.
  Eigen::Vector3d alpha_WB_B = Eigen::Vector3d::Zero();
};

/// Force and moment about the centre of gravity, in B: N, N m.
struct Wrench {
  Eigen::Vector3d force_B = Eigen::Vector3d::Zero();
  Eigen::Vector3d torque_B = Eigen::Vector3d::Zero();
};

/// The air and the field around one vehicle.
struct Environment {
  Eigen::Vector3d gravity_W{0, 0, 0};                ///< m/s^2
  Eigen::Vector3d wind_W = Eigen::Vector3d::Zero();  ///< air velocity, m/s
  /// 1/s: at r_W from the centre of gravity the air moves with wind_W + wind_gradient_W r_W;
  /// nullopt: as at the centre.
  std::optional<Eigen::Matrix3d> wind_gradient_W;
  double air_density_kg_m3 = 0;  ///< of World::atmosphere() at the vehicle's altitude
  /// Height of the centre of gravity over the surface below; infinite where there is none.
  double height_above_ground_m = 0;
};

/// The first surface that a ray meets.
struct RayHit {
  /// From the ray's origin; infinite: no surface within the range.
  double distance_m = std::numeric_limits<double>::infinity();
  /// Unit normal of the surface, against the ray; in the axes that the ray is given in.
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();
};

/// A force with internal states (rotor speeds, say) that the world integrates together with the
/// body: it is asked for its derivatives at every stage of the integrator, so it must be pure.
class ForceModel {
 public:
  /// Most internal states of one model.
  static constexpr int kMaxStates = 32;
  virtual ~ForceModel() = default;

  /// Number of internal states, at most kMaxStates, fixed for life.
  virtual int state_count() const = 0;
  /// Writes the initial states (at time zero and at reset).
  virtual void initial_states(std::span<double> x) const = 0;
  /// Adds to `wrench` and writes x_dot (per second) for the states x.
  virtual void evaluate(const BodyState& body, const Environment& environment,
                        std::span<const double> x, std::span<double> x_dot,
                        Wrench& wrench) const = 0;
  /// Brings states back into their limits after a step.
  virtual void limit(std::span<double>) const {}
};

/// The part of the simulation that plugins may read and change. `pre_step` gets it mutable,
/// `post_step` const.
class World {
 public:
  virtual ~World() = default;

  /// True motion after the last step.
  virtual const BodyState& state(VehicleId vehicle) const = 0;
  /// Internal states of a registered force model, after the last step.
  virtual std::span<const double> states_of(const ForceModel& model) const = 0;
  /// Air, gravity and ground at the vehicle.
  virtual const Environment& environment(VehicleId vehicle) const = 0;
  /// Mass, rotors and any scale_mass() included.
  virtual double mass_kg(VehicleId vehicle) const = 0;
  /// Whether it touches the world or another vehicle.
  virtual bool in_contact(VehicleId vehicle) const = 0;
  /// Maps W (east, north, up about the world's origin) to the Earth: projection().to_geodetic(p_N).
  virtual const base::LocalProjection& projection() const = 0;
  /// Decimal year of the simulated day, for the magnetic field.
  virtual double decimal_year() const = 0;
  /// Distance (m) along a ray to the first surface that is not the vehicle's own; nullopt when
  /// there is none within `range_m`. `direction_W` may have any length but 0.
  virtual std::optional<double> ray_distance(VehicleId vehicle, const Eigen::Vector3d& origin_W,
                                             const Eigen::Vector3d& direction_W,
                                             double range_m) const = 0;

  /// Velocity of the air at the vehicle, m/s, from the coming step on.
  virtual void set_wind_W(VehicleId vehicle, const Eigen::Vector3d& wind_W) = 0;
  /// Extra force and moment for the coming step only; calls add up.
  virtual void add_wrench(VehicleId vehicle, const Wrench& wrench) = 0;
  /// Sets mass and inertia to a multiple of those at the start; the centre of gravity stays.
  /// @throws base::ConfigError when `factor` is not above 0
  virtual void scale_mass(VehicleId vehicle, double factor) = 0;

  /// Whether a flat disc that is fixed to the vehicle, a rotor's, touches the world or another
  /// vehicle; cheap where nothing is near. A host without contacts says no.
  /// @param centre_B  from the centre of gravity, m
  /// @param axis_B    at right angles to the disc, of length 1
  virtual bool disc_touches(VehicleId vehicle, const Eigen::Vector3d& centre_B,
                            const Eigen::Vector3d& axis_B, double radius_m) const {
    (void)vehicle, (void)centre_B, (void)axis_B, (void)radius_m;
    return false;
  }

  /// The magnetic field in W, gauss, where the world has one of its own that is the same
  /// everywhere; nullopt: it is the Earth's.
  virtual std::optional<Eigen::Vector3d> magnetic_field_W() const { return std::nullopt; }

  /// How the wind changes over the vehicle, 1/s, from the coming step on. A host without such a
  /// wind ignores it.
  virtual void set_wind_gradient_W(VehicleId vehicle, const Eigen::Matrix3d& gradient_W) {
    (void)vehicle, (void)gradient_W;
  }

  /// The air by altitude above mean sea level.
  virtual base::Atmosphere atmosphere() const { return {}; }

  /// Casts rays into the world: ray i begins at `origins_W[i]`, along `directions_W[i]` of any
  /// length but 0, and `hits[i]` is the first surface that is not the vehicle's own. Thousands of
  /// rays are quick if the plugin has called PluginContext::expect_rays(). A host without surface
  /// normals takes each surface to face the ray.
  virtual void cast(VehicleId vehicle, std::span<const Eigen::Vector3d> origins_W,
                    std::span<const Eigen::Vector3d> directions_W, double range_m,
                    std::span<RayHit> hits) const {
    for (std::size_t i = 0; i < hits.size(); ++i) {
      const auto distance = ray_distance(vehicle, origins_W[i], directions_W[i], range_m);
      hits[i] = {};
      if (distance) hits[i] = {*distance, -directions_W[i].normalized()};
    }
  }
};

}  // namespace cas::sim
