// SPDX-License-Identifier: BSD-3-Clause
#include "libsim/core/load/mesh_file.hpp"

#include <limits>
#include <string>
#include <utility>

#include "base/error.hpp"
#include "base/read_file.hpp"
#include "base/text.hpp"
#include "libsim/core/load/collada.hpp"
#include "libsim/core/load/obj.hpp"
#include "libsim/core/load/stl.hpp"

namespace cas::sim {

namespace {

/// Five million triangles of binary STL.
constexpr std::size_t kMostBytes = 256U << 20U;
constexpr double kFarthest_m = 1e8;

[[noreturn]] void fail(const std::string& file, const std::string& sentence) {
  throw base::ConfigError(file + ": " + sentence);
}

/// With a negative scale the mesh is mirrored: its triangles keep their outer side.
void scale_by(const Eigen::Vector3d& scale, const std::string& file, TriangleMesh& mesh) {
  for (Eigen::Vector3d& v : mesh.vertices) {
    v = v.cwiseProduct(scale);
    if (!(v.cwiseAbs().maxCoeff() <= kFarthest_m)) {
      fail(file, "mesh has a vertex that is not finite, or farther away than 1e8 m");
    }
  }
  if (scale.prod() > 0) return;
  for (auto& triangle : mesh.triangles) std::swap(triangle[1], triangle[2]);
}

}  // namespace

TriangleMesh parse_mesh(std::string_view bytes, const std::filesystem::path& file,
                        const MeshOptions& options) {
  const std::string kind = base::lower(file.extension().string());
  const std::string name = file.string();
  TriangleMesh mesh;
  if (kind == ".stl") {
    mesh = parse_stl(bytes, name, options);
  } else if (kind == ".obj") {
    mesh = parse_obj(bytes, name, options);
  } else if (kind == ".dae") {
    mesh = parse_collada(bytes, name, options);
  } else {
    fail(name, "mesh format is not supported; convert it to STL, OBJ or COLLADA");
  }
  if (mesh.triangles.empty()) fail(name, "mesh has no triangle");
  if (mesh.triangles.size() > kMostTriangles) {
    fail(name, "mesh has more than the " + std::to_string(kMostTriangles) +
                   " triangles that are simulated");
  }
  return mesh;
}

TriangleMesh load_mesh(const std::filesystem::path& file, const Eigen::Vector3d& scale,
                       const MeshOptions& options) {
  if (!(scale.cwiseAbs().minCoeff() > 0)) fail(file.string(), "a mesh cannot be scaled by 0");
  TriangleMesh mesh = parse_mesh(base::read_foreign_file(file, "mesh", kMostBytes), file, options);
  scale_by(scale, file.string(), mesh);
  return mesh;
}

Box bounding_box(const TriangleMesh& mesh, Eigen::Vector3d& centre) {
  Eigen::Vector3d low = Eigen::Vector3d::Constant(std::numeric_limits<double>::infinity());
  Eigen::Vector3d high = -low;
  for (const Eigen::Vector3d& v : mesh.vertices) {
    low = low.cwiseMin(v);
    high = high.cwiseMax(v);
  }
  centre = 0.5 * (low + high);
  return Box{high - low};
}

}  // namespace cas::sim
