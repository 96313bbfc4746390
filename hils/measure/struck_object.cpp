// SPDX-License-Identifier: BSD-3-Clause
#include "hils/measure/struck_object.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <variant>

#include "base/error.hpp"
#include "libsim/core/load/sim_config.hpp"
#include "libsim/core/load/world_loader.hpp"

namespace cas::hils {

namespace {

using Eigen::Vector3d;

constexpr double kReach_m = 3;  // from the centre of a vehicle to where it touches

/// Nearest point of a triangle.
/// Source: C. Ericson, Real-Time Collision Detection, 2005, section 5.1.5.
double distance_to(const Vector3d& p, const Vector3d& a, const Vector3d& b, const Vector3d& c) {
  const auto to_edge = [&p](const Vector3d& from, const Vector3d& to) {
    const Vector3d edge = to - from;
    const double length = edge.squaredNorm();
    const double share = length > 0 ? std::clamp((p - from).dot(edge) / length, 0.0, 1.0) : 0;
    return (from + share * edge - p).norm();
  };
  const double edges = std::min({to_edge(a, b), to_edge(b, c), to_edge(c, a)});
  const Vector3d normal = (b - a).cross(c - a);
  const double area = normal.norm();
  if (!(area > 0)) return edges;
  const auto inside = [&](const Vector3d& from, const Vector3d& to) {
    return normal.dot((to - from).cross(p - from)) >= 0;
  };
  const bool above = inside(a, b) && inside(b, c) && inside(c, a);
  return above ? std::abs(normal.dot(p - a)) / area : edges;
}

struct DistanceTo {
  Vector3d p;  ///< in the shape's own frame

  double operator()(const sim::Box& box) const {
    return (p.cwiseAbs() - box.size_m / 2).cwiseMax(0).norm();
  }
  double operator()(const sim::Sphere& ball) const {
    return std::max(p.norm() - ball.radius_m, 0.0);
  }
  double operator()(const sim::Cylinder& cylinder) const {
    return std::hypot(std::max(std::hypot(p.x(), p.y()) - cylinder.radius_m, 0.0),
                      std::max(std::abs(p.z()) - cylinder.length_m / 2, 0.0));
  }
  double operator()(const sim::Plane&) const { return std::numeric_limits<double>::infinity(); }
  double operator()(const sim::Mesh& mesh) const {
    double least = std::numeric_limits<double>::infinity();
    const auto& v = mesh.triangles->vertices;
    for (const auto& [a, b, c] : mesh.triangles->triangles) {
      least = std::min(least, distance_to(p, v[a], v[b], v[c]));
    }
    return least;
  }
};

}  // namespace

std::optional<sim::WorldModel> flown_world(const std::filesystem::path& simulator_config) {
  try {
    const sim::SimConfig config = sim::SimConfig::load(simulator_config);
    if (config.world.sdf || config.terrain) return sim::load_world(config);
  } catch (const base::ConfigError&) {  // neither verdict nor replay needs it
  }
  return std::nullopt;
}

std::string nearest_object(const sim::WorldModel& world, double time_s, const Vector3d& place_W,
                           double reach_m) {
  std::string name;
  double least_m = reach_m;
  const auto look = [&](const sim::Shape& shape, const Eigen::Isometry3d& X_WP,
                        const std::string& who) {
    const double away_m =
        std::visit(DistanceTo{(X_WP * shape.pose).inverse() * place_W}, shape.geometry);
    if (away_m > least_m) return;
    least_m = away_m;
    name = who;
  };
  for (const sim::Shape& shape : world.statics) {
    look(shape, Eigen::Isometry3d::Identity(), shape.name.substr(0, shape.name.find('/')));
  }
  for (const sim::MovingObstacle& obstacle : world.moving) {
    const sim::BodyState state = obstacle.path.at(time_s);
    Eigen::Isometry3d X_WO = Eigen::Isometry3d::Identity();
    X_WO.translate(state.p_WB).rotate(state.q_WB);
    for (const sim::Shape& shape : obstacle.shapes) look(shape, X_WO, obstacle.name);
  }
  return name;
}

void name_struck_objects(const std::filesystem::path& simulator_config,
                         std::span<const PoseSample> truth, std::vector<Incident>& incidents) {
  const std::string unnamed = "hit " + std::string(kSomething);
  const auto is_unnamed = [&](const Incident& each) { return each.what.starts_with(unnamed); };
  if (std::ranges::none_of(incidents, is_unnamed)) return;
  const std::optional<sim::WorldModel> world = flown_world(simulator_config);
  if (!world) return;
  for (Incident& incident : incidents) {
    if (!is_unnamed(incident)) continue;
    const auto at = std::ranges::lower_bound(
        truth, static_cast<std::int64_t>(std::llround(incident.time_s * 1e6)), {},
        &PoseSample::time_us);
    if (at == truth.end()) continue;
    const Vector3d place_W(at->pose.y_m, at->pose.x_m, at->pose.z_m);
    const std::string name = nearest_object(*world, incident.time_s, place_W, kReach_m);
    if (!name.empty()) incident.what.replace(4, kSomething.size(), "'" + name + "'");
  }
}

}  // namespace cas::hils
