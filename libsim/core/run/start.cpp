// SPDX-License-Identifier: BSD-3-Clause
#include "libsim/core/run/start.hpp"

#include <fmt/format.h>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <string>
#include <variant>

#include "base/angles.hpp"
#include "base/error.hpp"
#include "libsim/core/ode/contact_solver.hpp"
#include "libsim/core/run/sim_world.hpp"
#include "libsim/core/terrain/terrain.hpp"

namespace cas::sim {

namespace {

/// Less is a start on a surface: PX4's plane of asphalt lies 5 cm over the ground; and a millimetre
/// of rounding.
constexpr double kOverlap_m = 0.051;
constexpr double kStep_s = 1e-3;
constexpr double kHighest_m = 1e4;  // a ray down from here meets the topmost surface

/// Whether a closed mesh is around a point: a ray to anywhere leaves it an odd number of times.
bool is_inside(const TriangleMesh& mesh, const Eigen::Vector3d& p) {
  const Eigen::Vector3d ray = Eigen::Vector3d(0.31, 0.47, 0.83).normalized();  // along no edge
  bool inside = false;
  for (const auto& t : mesh.triangles) {
    const Eigen::Vector3d& a = mesh.vertices[t[0]];
    const Eigen::Vector3d ab = mesh.vertices[t[1]] - a;
    const Eigen::Vector3d ac = mesh.vertices[t[2]] - a;
    // Moeller and Trumbore: p + s ray = a + u ab + v ac.
    const Eigen::Vector3d h = ray.cross(ac);
    const double det = ab.dot(h);
    if (std::abs(det) < 1e-15) continue;
    const Eigen::Vector3d q = (p - a).cross(ab);
    const double u = (p - a).dot(h) / det;
    const double v = ray.dot(q) / det;
    if (u >= 0 && v >= 0 && u + v <= 1 && ac.dot(q) / det > 0) inside = !inside;
  }
  return inside;
}

/// Whether a vehicle, raised by the overlap that is allowed, is in a shape.
bool overlaps(const Shape& shape, const VehicleModel& model, BodyState state) {
  ContactSolver solver(Eigen::Vector3d::Zero());
  solver.add_static(shape);
  solver.add_body(model.shapes, model.mass);
  if (!solver.near_world(0, state.p_WB)) return false;
  if (const auto* const mesh = std::get_if<Mesh>(&shape.geometry)) {
    if (is_inside(*mesh->triangles, shape.pose.inverse() * state.p_WB)) return true;
  }
  state.p_WB.z() += kOverlap_m;
  solver.begin(kStep_s);
  solver.place(0, state);
  solver.collide_world(0);
  return solver.touching(0);
}

double radius_of(const VehicleModel& model) {
  double radius = 0;
  for (const Shape& shape : model.shapes) radius = std::max(radius, bounding_radius(shape));
  return radius;
}

/// Cheap: whether the spheres around shape and vehicle meet.
bool is_near(Shape shape, const Eigen::Vector3d& p_W, double radius) {
  const Eigen::Vector3d centre = shape.pose.translation();
  shape.pose.translation().setZero();
  return (centre - p_W).norm() <= bounding_radius(shape) + radius;  // a plane's is infinite
}

Eigen::Matrix3d turned_by(const StartPose& pose) {
  return Eigen::AngleAxisd(base::radians(pose.yaw_deg), Eigen::Vector3d::UnitZ())
      .toRotationMatrix();
}

/// How far a vehicle reaches along a direction from its centre of gravity, m.
double reach(const VehicleModel& model, const Eigen::Matrix3d& R_WB, const Eigen::Vector3d& d_W) {
  const Eigen::Matrix3d down =
      Eigen::Quaterniond::FromTwoVectors(d_W, -Eigen::Vector3d::UnitZ()).toRotationMatrix();
  double farthest = 0;
  for (const Shape& shape : model.shapes) {
    farthest = std::max(farthest, -lowest_point(shape, down * R_WB));
  }
  return farthest;
}

/// A grid of 5 x 5 places over the base of a vehicle: x, y in W, m.
std::array<Eigen::Vector2d, 25> base_of(const VehicleModel& model, const StartPose& pose) {
  constexpr int kCells = 4;  // along an edge
  const Eigen::Matrix3d R_WB = turned_by(pose);
  const Eigen::Vector2d low(-reach(model, R_WB, -Eigen::Vector3d::UnitX()),
                            -reach(model, R_WB, -Eigen::Vector3d::UnitY()));
  const Eigen::Vector2d high(reach(model, R_WB, Eigen::Vector3d::UnitX()),
                             reach(model, R_WB, Eigen::Vector3d::UnitY()));
  std::array<Eigen::Vector2d, 25> places;
  std::size_t n = 0;
  for (int i = 0; i <= kCells; ++i) {
    for (int j = 0; j <= kCells; ++j) {
      const Eigen::Vector2d part = Eigen::Vector2d(i, j) / kCells;
      places[n++] = Eigen::Vector2d(pose.x_m, pose.y_m) + low + part.cwiseProduct(high - low);
    }
  }
  return places;
}

/// @throws base::ConfigError that a vehicle starts inside something
[[noreturn]] void refuse_start(const SimWorld& world, const VehicleConfig& vehicle,
                               const std::string& obstacle) {
  const StartPose& pose = vehicle.pose;
  std::string sentence = fmt::format(
      "vehicle '{}', obstacle '{}': the vehicle starts inside it: x_m {:.2f}, y_m {:.2f}, z_m "
      "{:.2f}",
      vehicle.name, obstacle, pose.x_m, pose.y_m, pose.z_m.value_or(0));
  if (const auto top = surface_at(world, pose.x_m, pose.y_m)) {
    sentence += fmt::format("; the uppermost surface there is at z_m {:.2f}", *top);
  }
  throw base::ConfigError(sentence + "; give it another 'pose'");
}

}  // namespace

std::optional<double> surface_at(const SimWorld& world, double x_m, double y_m) {
  const auto hit =
      world.ray_to_statics({x_m, y_m, kHighest_m}, -Eigen::Vector3d::UnitZ(), 2 * kHighest_m);
  if (!hit) return std::nullopt;
  return kHighest_m - *hit;
}

double standing_height(const SimWorld& world, const VehicleModel& model, const StartPose& pose) {
  std::optional<double> top;
  for (const Eigen::Vector2d& place : base_of(model, pose)) {
    const auto z = surface_at(world, place.x(), place.y());
    if (z) top = std::max(top.value_or(*z), *z);
  }
  return top.value_or(0);
}

BodyState start_state(const VehicleModel& model, const StartPose& pose) {
  BodyState state;
  const double yaw = base::radians(pose.yaw_deg);
  state.q_WB = Eigen::Quaterniond(Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ()));
  double lowest = std::numeric_limits<double>::infinity();
  for (const Shape& shape : model.shapes) {
    lowest = std::min(lowest, lowest_point(shape, state.q_WB.toRotationMatrix()));
  }
  state.p_WB = {pose.x_m, pose.y_m, pose.z_m.value_or(0) - lowest};
  return state;
}

void require_free_start(const SimWorld& world, const WorldModel& world_model,
                        const VehicleModel& model, const VehicleConfig& vehicle) {
  const BodyState state = start_state(model, vehicle.pose);
  const double radius = radius_of(model);
  for (const Shape& shape : world_model.statics) {
    if (!is_near(shape, state.p_WB, radius) || !overlaps(shape, model, state)) continue;
    refuse_start(world, vehicle, shape.name);
  }
  const Eigen::Vector3d& p_W = state.p_WB;
  if (world_model.terrain && p_W.z() < world_model.terrain->height_m(p_W.x(), p_W.y())) {
    refuse_start(world, vehicle, "terrain");
  }
}

void require_ground(const SimWorld& world, const WorldModel& world_model, const VehicleModel& model,
                    const VehicleConfig& vehicle, const std::filesystem::path& file) {
  if (!(world_model.gravity_W.z() < 0)) return;
  ContactSolver obstacles(Eigen::Vector3d::Zero());
  for (const MovingObstacle& obstacle : world_model.moving) {
    const BodyState at_start = obstacle.path.at(0);
    for (Shape shape : obstacle.shapes) {
      shape.pose = Eigen::Translation3d(at_start.p_WB) * at_start.q_WB * shape.pose;
      obstacles.add_static(shape);
    }
  }
  const double from_m = start_state(model, vehicle.pose).p_WB.z();
  const auto is_over_something = [&](const Eigen::Vector2d& place) {
    const Eigen::Vector3d origin_W(place.x(), place.y(), from_m);
    const Eigen::Vector3d down_W = -Eigen::Vector3d::UnitZ();
    return world.ray_to_statics(origin_W, down_W, 2 * kHighest_m) ||
           obstacles.ray_to_world(origin_W, down_W, 2 * kHighest_m);
  };
  const auto places = base_of(model, vehicle.pose);
  if (std::any_of(places.begin(), places.end(), is_over_something)) return;
  const std::string place = fmt::format("x_m {:.2f}, y_m {:.2f}, z_m {:.2f}", vehicle.pose.x_m,
                                        vehicle.pose.y_m, vehicle.pose.z_m.value_or(0));
  throw base::ConfigError(
      file.string() + ": the world '" + world_model.name +
      "' has no ground below the start of vehicle '" + vehicle.name + "' (" + place +
      "), which would fall for ever; give it a 'pose' over something, or the world a ground: "
      "<include><uri>model://ground_plane</uri></include>");
}

}  // namespace cas::sim
