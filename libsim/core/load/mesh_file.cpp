// SPDX-License-Identifier: BSD-3-Clause
#include "libsim/core/load/mesh_file.hpp"

#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>
#include <numeric>
#include <string>
#include <utility>
#include <vector>

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

/// For each vertex the number of one in the same place, the same for all of them.
std::vector<std::uint32_t> places_of(const std::vector<Eigen::Vector3d>& vertices) {
  std::vector<std::uint32_t> sorted(vertices.size());
  std::iota(sorted.begin(), sorted.end(), 0U);
  std::sort(sorted.begin(), sorted.end(), [&](std::uint32_t a, std::uint32_t b) {
    return std::lexicographical_compare(vertices[a].begin(), vertices[a].end(), vertices[b].begin(),
                                        vertices[b].end());
  });
  std::vector<std::uint32_t> places(vertices.size());
  for (std::size_t i = 0; i < sorted.size(); ++i) {
    const bool again = i > 0 && vertices[sorted[i]] == vertices[sorted[i - 1]];
    places[sorted[i]] = again ? places[sorted[i - 1]] : sorted[i];
  }
  return places;
}

/// A triangle that stands in the file many times adds nothing to a body, but ODE's tree of boxes
/// cannot part such triangles and takes the square of their number to build.
void leave_out_repeats(const std::string& file, const MeshOptions& options, TriangleMesh& mesh) {
  const std::vector<std::uint32_t> places = places_of(mesh.vertices);
  // Corners, the smallest first, and the triangle's number.
  std::vector<std::array<std::uint32_t, 4>> sorted;
  for (std::uint32_t i = 0; i < mesh.triangles.size(); ++i) {
    const auto [a, b, c] = mesh.triangles[i];
    std::array<std::uint32_t, 3> corners{places[a], places[b], places[c]};
    std::rotate(corners.begin(), std::min_element(corners.begin(), corners.end()), corners.end());
    sorted.push_back({corners[0], corners[1], corners[2], i});
  }
  std::sort(sorted.begin(), sorted.end());
  std::vector<bool> repeats(sorted.size());
  for (std::size_t i = 1; i < sorted.size(); ++i) {
    repeats[sorted[i][3]] =
        std::equal(sorted[i].begin(), sorted[i].begin() + 3, sorted[i - 1].begin());
  }
  std::vector<std::array<std::uint32_t, 3>> kept;
  for (std::size_t i = 0; i < repeats.size(); ++i) {
    if (!repeats[i]) kept.push_back(mesh.triangles[i]);
  }
  const std::size_t left_out = mesh.triangles.size() - kept.size();
  if (left_out == 0) return;
  mesh.triangles = std::move(kept);
  options.warn(file + ": triangles left out that repeat others corner for corner: " +
               std::to_string(left_out));
}

TriangleMesh parse_kind(std::string_view bytes, const std::filesystem::path& file,
                        const MeshOptions& options) {
  const std::string kind = base::lower(file.extension().string());
  const std::string name = file.string();
  if (kind == ".dae") return parse_collada(bytes, name, options);
  if (bytes.starts_with("\xff\xfe") || bytes.starts_with("\xfe\xff")) {
    fail(name, "is text in UTF-16; save it as UTF-8");
  }
  return kind == ".stl" ? parse_stl(bytes, name, options) : parse_obj(bytes, name, options);
}

}  // namespace

std::optional<std::string> mesh_kind_refusal(const std::filesystem::path& file) {
  const std::string kind = base::lower(file.extension().string());
  if (kind == ".stl" || kind == ".obj" || kind == ".dae") return std::nullopt;
  return file.string() + ": mesh format is not supported; convert it to STL, OBJ or COLLADA";
}

TriangleMesh parse_mesh(std::string_view bytes, const std::filesystem::path& file,
                        const MeshOptions& options) {
  if (bytes.starts_with("version https://git-lfs.github.com/spec/")) {
    fail(file.string(), "is a pointer of Git LFS, not the mesh; get that by 'git lfs pull'");
  }
  if (const auto refusal = mesh_kind_refusal(file)) throw base::ConfigError(*refusal);
  std::vector<std::string> notes;
  TriangleMesh mesh = parse_kind(bytes, file, {.up_axis = options.up_axis, .warnings = &notes});
  if (mesh.triangles.empty()) {
    fail(file.string(), "mesh has no triangle" + (notes.empty() ? "" : "; " + notes.front()));
  }
  for (std::string& note : notes) options.warn(std::move(note));
  if (mesh.triangles.size() > kMostTriangles) {
    fail(file.string(), "mesh has more than the " + std::to_string(kMostTriangles) +
                            " triangles that are simulated");
  }
  return mesh;
}

TriangleMesh load_mesh(const std::filesystem::path& file, const Eigen::Vector3d& scale,
                       const MeshOptions& options) {
  if (!(scale.cwiseAbs().minCoeff() > 0)) fail(file.string(), "a mesh cannot be scaled by 0");
  TriangleMesh mesh = parse_mesh(base::read_foreign_file(file, "mesh", kMostBytes), file, options);
  scale_by(scale, file.string(), mesh);
  leave_out_repeats(file.string(), options, mesh);
  return mesh;
}

Box bounding_box(const TriangleMesh& mesh, Eigen::Vector3d& centre) {
  Eigen::Vector3d low = Eigen::Vector3d::Constant(std::numeric_limits<double>::infinity());
  Eigen::Vector3d high = -low;
  for (const auto& triangle : mesh.triangles) {
    for (const std::uint32_t corner : triangle) {
      low = low.cwiseMin(mesh.vertices[corner]);
      high = high.cwiseMax(mesh.vertices[corner]);
    }
  }
  centre = 0.5 * (low + high);
  return Box{high - low};
}

}  // namespace cas::sim
