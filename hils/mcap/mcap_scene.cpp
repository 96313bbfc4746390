// SPDX-License-Identifier: BSD-3-Clause
#include "hils/mcap/mcap_scene.hpp"

#include <nlohmann/json.hpp>
#include <utility>
#include <variant>

#include "mavlink_gen/json/message_codec.hpp"

namespace cas::hils {

namespace {

using mav::services::number_json;
using OrderedJson = nlohmann::ordered_json;

constexpr McapColor kDiscColor{0.35, 0.55, 0.85, 0.35};
constexpr McapColor kArmColor{0.3, 0.3, 0.32, 1};

OrderedJson scene_color_json(const McapColor& color) {
  return {{"r", color.r}, {"g", color.g}, {"b", color.b}, {"a", color.a}};
}

OrderedJson scene_pose_json(const Eigen::Isometry3d& pose) {
  return {{"position", mcap_vector(pose.translation())},
          {"orientation", mcap_quaternion(Eigen::Quaterniond(pose.rotation()))}};
}

OrderedJson scene_cylinder_json(const Eigen::Isometry3d& pose, double radius_m, double length_m,
                                const McapColor& color) {
  return {{"pose", scene_pose_json(pose)},
          {"size", mcap_vector({2 * radius_m, 2 * radius_m, length_m})},
          {"bottom_scale", 1},
          {"top_scale", 1},
          {"color", scene_color_json(color)}};
}

OrderedJson scene_line_json(int type, double thickness_m, OrderedJson points,
                            const McapColor& color) {
  return {{"type", type},
          {"pose", scene_pose_json(Eigen::Isometry3d::Identity())},
          {"thickness", thickness_m},
          {"scale_invariant", false},
          {"points", std::move(points)},
          {"color", scene_color_json(color)},
          {"colors", OrderedJson::array()},
          {"indices", OrderedJson::array()}};
}

OrderedJson scene_triangles_json(const Eigen::Isometry3d& pose, const sim::TriangleMesh& mesh,
                                 const McapColor& color) {
  OrderedJson points = OrderedJson::array();
  for (const Eigen::Vector3d& vertex : mesh.vertices) points.push_back(mcap_vector(vertex));
  OrderedJson indices = OrderedJson::array();
  for (const auto& triangle : mesh.triangles) {
    for (const std::uint32_t index : triangle) indices.push_back(index);
  }
  return {{"pose", scene_pose_json(pose)},
          {"points", std::move(points)},
          {"color", scene_color_json(color)},
          {"colors", OrderedJson::array()},
          {"indices", std::move(indices)}};
}

OrderedJson empty_scene_entity(const std::string& id, const std::string& frame) {
  OrderedJson entity{{"timestamp", mcap_time({})},
                     {"frame_id", frame},
                     {"id", id},
                     {"lifetime", mcap_time({})},
                     {"frame_locked", true}};
  for (const char* kind : {"metadata", "arrows", "cubes", "spheres", "cylinders", "lines",
                           "triangles", "texts", "models"}) {
    entity[kind] = OrderedJson::array();
  }
  return entity;
}

/// Adds a shape to those of its kind.
class AddToEntity {
 public:
  AddToEntity(OrderedJson& entity, const Eigen::Isometry3d& pose, const McapColor& color)
      : entity_(entity), pose_(pose), color_(color) {}

  void operator()(const sim::Box& box) const {
    entity_["cubes"].push_back({{"pose", scene_pose_json(pose_)},
                                {"size", mcap_vector(box.size_m)},
                                {"color", scene_color_json(color_)}});
  }
  void operator()(const sim::Sphere& ball) const {
    entity_["spheres"].push_back(
        {{"pose", scene_pose_json(pose_)},
         {"size", mcap_vector(Eigen::Vector3d::Constant(2 * ball.radius_m))},
         {"color", scene_color_json(color_)}});
  }
  void operator()(const sim::Cylinder& cylinder) const {
    entity_["cylinders"].push_back(
        scene_cylinder_json(pose_, cylinder.radius_m, cylinder.length_m, color_));
  }
  void operator()(const sim::Plane&) const {}
  void operator()(const sim::Mesh& mesh) const {
    entity_["triangles"].push_back(scene_triangles_json(pose_, *mesh.triangles, color_));
  }

 private:
  OrderedJson& entity_;
  const Eigen::Isometry3d& pose_;
  const McapColor& color_;
};

}  // namespace

OrderedJson mcap_time(base::SimTime time) {
  constexpr std::int64_t kSecond = 1'000'000'000;
  const std::int64_t ns = time.time_since_epoch().count();
  return {{"sec", ns / kSecond}, {"nsec", ns % kSecond}};
}

OrderedJson mcap_vector(const Eigen::Vector3d& vector) {
  return {{"x", number_json(vector.x())},
          {"y", number_json(vector.y())},
          {"z", number_json(vector.z())}};
}

OrderedJson mcap_quaternion(const Eigen::Quaterniond& q) {
  return {{"x", number_json(q.x())},
          {"y", number_json(q.y())},
          {"z", number_json(q.z())},
          {"w", number_json(q.w())}};
}

OrderedJson mcap_entity(const std::string& id, const std::string& frame,
                        std::span<const sim::Shape> shapes, const McapColor& color) {
  OrderedJson entity = empty_scene_entity(id, frame);
  for (const sim::Shape& shape : shapes) {
    std::visit(AddToEntity(entity, shape.pose, color), shape.geometry);
  }
  return entity;
}

OrderedJson mcap_rotors(const std::string& id, const std::string& frame,
                        std::span<const base::Rotor> rotors) {
  constexpr double kDiscThickness_m = 0.004;
  constexpr double kArmThickness_m = 0.01;
  OrderedJson entity = empty_scene_entity(id, frame);
  OrderedJson ends = OrderedJson::array();
  for (const base::Rotor& rotor : rotors) {
    Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
    pose.translate(rotor.position_B_m)
        .rotate(Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::UnitZ(), rotor.axis_B));
    entity["cylinders"].push_back(
        scene_cylinder_json(pose, rotor.params.radius_m, kDiscThickness_m, kDiscColor));
    ends.push_back(mcap_vector(Eigen::Vector3d::Zero()));
    ends.push_back(mcap_vector(rotor.position_B_m));
  }
  constexpr int kLineForEachTwo = 2;
  if (!ends.empty()) {
    entity["lines"].push_back(
        scene_line_json(kLineForEachTwo, kArmThickness_m, std::move(ends), kArmColor));
  }
  return entity;
}

OrderedJson mcap_line(const std::string& id, const std::string& frame,
                      std::span<const Eigen::Vector3d> points, const McapColor& color) {
  constexpr double kThickness_m = 0.02;
  constexpr int kPointToPoint = 0;
  OrderedJson entity = empty_scene_entity(id, frame);
  OrderedJson places = OrderedJson::array();
  for (const Eigen::Vector3d& point : points) places.push_back(mcap_vector(point));
  if (!places.empty()) {
    entity["lines"].push_back(
        scene_line_json(kPointToPoint, kThickness_m, std::move(places), color));
  }
  return entity;
}

}  // namespace cas::hils
