// SPDX-License-Identifier: BSD-3-Clause
#include "libsim/core/load/visuals.hpp"

#include <bit>
#include <cstdint>
#include <cstring>
#include <memory>
#include <utility>
#include <variant>

#include "base/error.hpp"
#include "libsim/core/load/mesh_file.hpp"

namespace cas::sim {

namespace {

template <class Number>
void append(std::string& bytes, Number value) {
  static_assert(std::endian::native == std::endian::little && sizeof(Number) == 4);
  char raw[sizeof value];
  std::memcpy(raw, &value, sizeof value);
  bytes.append(raw, sizeof raw);
}

/// Nothing, and a warning, for a mesh that cannot be read.
std::shared_ptr<const TriangleMesh> mesh_of(const MeshFile& file, const Visual& visual,
                                            UpAxis up_axis, std::vector<std::string>& warnings) {
  try {
    return std::make_shared<const TriangleMesh>(
        load_mesh(file.path, file.scale, {.up_axis = up_axis}));
  } catch (const base::ConfigError& error) {
    warnings.push_back(std::string(error.what()) + "; link '" + visual.name +
                       "' is drawn without this mesh");
    return nullptr;
  }
}

}  // namespace

std::vector<Shape> load_visuals(const VehicleModel& model, std::size_t most_triangles,
                                std::vector<std::string>& warnings) {
  std::vector<Shape> shapes;
  std::size_t triangles = 0;
  for (const Visual& visual : model.visuals) {
    Shape shape{.name = visual.name, .geometry = {}, .pose = visual.pose, .surface = {}};
    if (const auto* file = std::get_if<MeshFile>(&visual.form)) {
      auto mesh = mesh_of(*file, visual, model.up_axis, warnings);
      if (!mesh) continue;
      triangles += mesh->triangles.size();
      if (triangles > most_triangles) return {};
      shape.geometry = Mesh{std::move(mesh)};
    } else {
      shape.geometry = std::get<Geometry>(visual.form);
    }
    shapes.push_back(std::move(shape));
  }
  if (triangles == 0) shapes.clear();
  return shapes;
}

std::string mesh_bytes(const TriangleMesh& mesh) {
  std::string bytes;
  bytes.reserve(8 + 12 * (mesh.vertices.size() + mesh.triangles.size()));
  append(bytes, static_cast<std::uint32_t>(mesh.vertices.size()));
  append(bytes, static_cast<std::uint32_t>(mesh.triangles.size()));
  for (const Eigen::Vector3d& vertex : mesh.vertices) {
    for (const double coordinate : vertex) append(bytes, static_cast<float>(coordinate));
  }
  for (const auto& triangle : mesh.triangles) {
    for (const std::uint32_t index : triangle) append(bytes, index);
  }
  return bytes;
}

}  // namespace cas::sim
