// SPDX-License-Identifier: BSD-3-Clause
#include <embree3/rtcore.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <string>
#include <variant>
#include <vector>

#include "base/error.hpp"
#include "libsim/core/rays/convex_stretch.hpp"
#include "libsim/core/rays/ray_scene.hpp"

namespace cas::sim {

namespace {

/// Embree computes in single precision: its bounds and ranges are wider by this share.
constexpr double kSingle = 1e-6;

/// Embree's device, one for the process. Scenes are built on the caller's thread.
RTCDevice device() {
  static const RTCDevice made = rtcNewDevice("threads=1");
  return made;
}

void check_device() {
  const RTCError error = rtcGetDeviceError(device());
  if (error == RTC_ERROR_NONE) return;
  throw base::ConfigError("Embree cannot take the shapes of the world: error " +
                          std::to_string(error) +
                          (error == RTC_ERROR_OUT_OF_MEMORY ? ", out of memory" : ""));
}

struct RayPlane {
  Eigen::Vector3d n;  // unit
  double height_m;    // along n

  std::optional<RayHit> meet(const Eigen::Vector3d& origin,
                             const Eigen::Vector3d& direction) const {
    const double slope = n.dot(direction);
    if (slope == 0) return std::nullopt;
    const double distance = (height_m - n.dot(origin)) / slope;
    if (distance < 0) return std::nullopt;
    return RayHit{.distance_m = distance, .normal = n};
  }
};

/// A box, sphere or cylinder S in its place.
struct Solid {
  Geometry geometry;
  Eigen::Vector3d p;    // its middle
  Eigen::Matrix3d R_S;  // turns vectors into its own axes

  std::optional<RayHit> meet(const Eigen::Vector3d& origin,
                             const Eigen::Vector3d& direction) const {
    ConvexStretch stretch(R_S * (origin - p), R_S * direction);
    if (const auto* box = std::get_if<Box>(&geometry)) {
      for (const Eigen::Index axis : {0, 1, 2}) stretch.cut_by_slab(axis, box->size_m[axis] / 2);
    } else if (const auto* sphere = std::get_if<Sphere>(&geometry)) {
      stretch.cut_by_round(Eigen::Vector3d::Ones(), sphere->radius_m);
    } else {
      const auto& cylinder = std::get<Cylinder>(geometry);
      stretch.cut_by_round({1, 1, 0}, cylinder.radius_m);
      stretch.cut_by_slab(2, cylinder.length_m / 2);
    }
    auto hit = stretch.first();
    if (hit) hit->normal = R_S.transpose() * hit->normal;
    return hit;
  }

  /// Half of its extent along the axes of the scene.
  Eigen::Vector3d half_extent() const {
    if (const auto* box = std::get_if<Box>(&geometry)) {
      return R_S.transpose().cwiseAbs() * box->size_m / 2;
    }
    if (const auto* sphere = std::get_if<Sphere>(&geometry)) {
      return Eigen::Vector3d::Constant(sphere->radius_m);
    }
    const auto& cylinder = std::get<Cylinder>(geometry);
    const Eigen::Vector3d axis = R_S.row(2);
    const Eigen::Vector3d across = (1 - axis.array().square()).max(0).sqrt() * cylinder.radius_m;
    return axis.cwiseAbs() * cylinder.length_m / 2 + across;
  }
};

/// A mesh in its place.
struct PlacedMesh {
  std::shared_ptr<const TriangleMesh> triangles;
  Eigen::Isometry3d pose;

  /// The ray's hit with the plane of a triangle, in double precision.
  /// @param about_m  distance in single precision, for a triangle that is a line or a point
  RayHit meet(unsigned number, const Eigen::Vector3d& origin, const Eigen::Vector3d& direction,
              double about_m) const {
    const auto& [i, j, k] = triangles->triangles[number];
    const Eigen::Vector3d a = pose * triangles->vertices[i];
    const Eigen::Vector3d n =
        (pose * triangles->vertices[j] - a).cross(pose * triangles->vertices[k] - a).normalized();
    const double distance = n.dot(a - origin) / n.dot(direction);
    // Across a triangle's edge both precisions agree; along its plane neither says much.
    const bool agree = std::abs(distance - about_m) < 1e-3 * (1 + about_m);
    return {.distance_m = agree ? distance : about_m, .normal = n};
  }
};

/// One ray on its way through Embree, whole in double precision.
struct Query : RTCIntersectContext {
  const std::vector<Solid>* solids = nullptr;
  Eigen::Vector3d origin;
  Eigen::Vector3d direction;
  RayHit nearest;  // of the solids
};

void on_bounds(const RTCBoundsFunctionArguments* arguments) {
  const auto& solids = *static_cast<const std::vector<Solid>*>(arguments->geometryUserPtr);
  const Solid& solid = solids[arguments->primID];
  const Eigen::Vector3d half = solid.half_extent();
  const Eigen::Vector3d margin =
      Eigen::Vector3d::Constant(kSingle) + kSingle * (solid.p.cwiseAbs() + half);
  const Eigen::Vector3f low = (solid.p - half - margin).cast<float>();
  const Eigen::Vector3f high = (solid.p + half + margin).cast<float>();
  RTCBounds& bounds = *arguments->bounds_o;
  bounds.lower_x = low.x();
  bounds.lower_y = low.y();
  bounds.lower_z = low.z();
  bounds.upper_x = high.x();
  bounds.upper_y = high.y();
  bounds.upper_z = high.z();
}

void on_ray(const RTCIntersectFunctionNArguments* arguments) {
  if (arguments->valid[0] == 0) return;
  auto& query = *static_cast<Query*>(arguments->context);
  auto& found = *reinterpret_cast<RTCRayHit*>(arguments->rayhit);  // rays are cast one by one
  const auto hit = (*query.solids)[arguments->primID].meet(query.origin, query.direction);
  if (!hit || hit->distance_m >= query.nearest.distance_m || hit->distance_m > found.ray.tfar) {
    return;
  }
  query.nearest = *hit;
  found.ray.tfar = static_cast<float>(hit->distance_m);
  found.hit.geomID = arguments->geomID;
  found.hit.primID = arguments->primID;
}

class EmbreeScene final : public RayScene {
 public:
  explicit EmbreeScene(std::span<const Shape> shapes) : scene_(rtcNewScene(device())) {
    rtcSetSceneFlags(scene_, RTC_SCENE_FLAG_ROBUST);  // no ray slips through between triangles
    for (const Shape& shape : shapes) add(shape);
    attach_solids();
    rtcCommitScene(scene_);
    check_device();
  }
  ~EmbreeScene() override { rtcReleaseScene(scene_); }
  EmbreeScene(const EmbreeScene&) = delete;
  EmbreeScene& operator=(const EmbreeScene&) = delete;

  std::optional<RayHit> cast(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction,
                             double range_m) const override {
    std::optional<RayHit> nearest = first_shape(origin, direction, range_m);
    for (const RayPlane& plane : planes_) {
      const auto hit = plane.meet(origin, direction);
      if (hit && (!nearest || hit->distance_m < nearest->distance_m)) nearest = hit;
    }
    if (!nearest || nearest->distance_m > range_m) return std::nullopt;
    if (nearest->normal.dot(direction) > 0) nearest->normal = -nearest->normal;
    return nearest;
  }

 private:
  void add(const Shape& shape) {
    const Eigen::Vector3d p = shape.pose.translation();
    if (const auto* mesh = std::get_if<Mesh>(&shape.geometry)) {
      add_mesh({mesh->triangles, shape.pose});
    } else if (std::holds_alternative<Plane>(shape.geometry)) {
      const Eigen::Vector3d n = shape.pose.linear().col(2);
      planes_.push_back({n, n.dot(p)});
    } else {
      solids_.push_back({shape.geometry, p, shape.pose.linear().transpose()});
    }
  }

  /// Adds a mesh; its number in the scene is its index in `meshes_`.
  void add_mesh(const PlacedMesh& mesh) {
    const auto& [vertices, triangles] = *mesh.triangles;
    const RTCGeometry geometry = rtcNewGeometry(device(), RTC_GEOMETRY_TYPE_TRIANGLE);
    auto* const places = static_cast<float*>(
        rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                                3 * sizeof(float), vertices.size()));
    auto* const corners = static_cast<unsigned*>(
        rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                                3 * sizeof(unsigned), triangles.size()));
    check_device();
    for (std::size_t i = 0; i < vertices.size(); ++i) {
      Eigen::Map<Eigen::Vector3f>(places + 3 * i) = (mesh.pose * vertices[i]).cast<float>();
    }
    for (std::size_t i = 0; i < triangles.size(); ++i) {
      std::ranges::copy(triangles[i], corners + 3 * i);
    }
    rtcCommitGeometry(geometry);
    rtcAttachGeometry(scene_, geometry);
    rtcReleaseGeometry(geometry);
    meshes_.push_back(mesh);
  }

  void attach_solids() {
    if (solids_.empty()) return;
    const RTCGeometry geometry = rtcNewGeometry(device(), RTC_GEOMETRY_TYPE_USER);
    rtcSetGeometryUserPrimitiveCount(geometry, static_cast<unsigned>(solids_.size()));
    rtcSetGeometryUserData(geometry, &solids_);
    rtcSetGeometryBoundsFunction(
        geometry, [](const RTCBoundsFunctionArguments* a) { on_bounds(a); }, nullptr);
    rtcSetGeometryIntersectFunction(geometry,
                                    [](const RTCIntersectFunctionNArguments* a) { on_ray(a); });
    rtcCommitGeometry(geometry);
    rtcAttachGeometry(scene_, geometry);
    rtcReleaseGeometry(geometry);
  }

  /// The first surface but for planes; perhaps a little beyond the range.
  std::optional<RayHit> first_shape(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction,
                                    double range_m) const {
    Query query;
    rtcInitIntersectContext(&query);
    query.solids = &solids_;
    query.origin = origin;
    query.direction = direction;
    RTCRayHit found{};
    Eigen::Map<Eigen::Vector3f>(&found.ray.org_x) = origin.cast<float>();
    Eigen::Map<Eigen::Vector3f>(&found.ray.dir_x) = direction.cast<float>();
    found.ray.tfar = static_cast<float>(range_m * (1 + kSingle) + kSingle);
    found.ray.mask = ~0U;
    found.hit.geomID = RTC_INVALID_GEOMETRY_ID;
    rtcIntersect1(scene_, &query, &found);
    if (found.hit.geomID == RTC_INVALID_GEOMETRY_ID) return std::nullopt;
    if (found.hit.geomID == meshes_.size()) return query.nearest;
    return meshes_[found.hit.geomID].meet(found.hit.primID, origin, direction, found.ray.tfar);
  }

  RTCScene scene_;
  std::vector<RayPlane> planes_;
  std::vector<Solid> solids_;
  std::vector<PlacedMesh> meshes_;
};

}  // namespace

void cas_make_ray_scene(const std::span<const Shape>& shapes, std::unique_ptr<RayScene>& scene) {
  scene = std::make_unique<EmbreeScene>(shapes);
}

}  // namespace cas::sim
