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
#include "libsim/core/terrain/terrain.hpp"

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
    warnings.push_back(std::string(error.what()) + "; link '" + visual.link +
                       "' is drawn without this mesh");
    return nullptr;
  }
}

/// What a surface does where its visual is, by a deflection above 0: along the visual's own z, as
/// far as the sign counts.
double effect_along_z(const Shape& visual, std::size_t surface, const base::AeroParams& aero) {
  const Eigen::Vector3d z_B = visual.pose.linear().col(2);
  for (const base::PanelParams& panel : aero.panels) {
    if (panel.surface == static_cast<int>(surface)) {
      return panel.surface_lift_per_rad * panel.normal_B.dot(z_B);
    }
  }
  if (!aero.derivatives) return 0;
  const base::DerivativeParams& body = *aero.derivatives;
  const auto row = [surface](const base::CoefficientRow& coefficient) {
    return surface < coefficient.surfaces.size() ? coefficient.surfaces[surface] : 0.0;
  };
  // The rows' moments are about forward, right, down; B is forward, left, up.
  const Eigen::Vector3d moment_B(row(body.roll) * body.span_m, -row(body.pitch) * body.chord_m,
                                 -row(body.yaw) * body.span_m);
  return visual.pose.translation().cross(z_B).dot(moment_B);
}

/// Whether a visual has a surface's name, or that of one of its two sides.
bool is_named(const std::string& visual, const std::string& surface) {
  return visual == surface || visual == surface + "_left" || visual == surface + "_right";
}

}  // namespace

std::vector<DrawnSurface> drawn_surfaces(std::span<const Shape> visuals,
                                         const base::AeroParams& aero) {
  std::vector<DrawnSurface> drawn;
  for (std::size_t i = 0; i < visuals.size(); ++i) {
    if (!std::holds_alternative<Box>(visuals[i].geometry)) continue;
    for (std::size_t k = 0; k < aero.surfaces.size(); ++k) {
      if (!is_named(visuals[i].name, aero.surfaces[k].name)) continue;
      // The surface's rear edge goes to -z where it pushes to +z; that is a turn about -y.
      drawn.push_back({i, k, effect_along_z(visuals[i], k, aero) > 0 ? -1.0 : 1.0});
      break;
    }
  }
  return drawn;
}

std::vector<Shape> load_visuals(const VehicleModel& model, bool has_wings,
                                std::size_t most_triangles, std::vector<std::string>& warnings) {
  std::vector<Shape> shapes;
  std::size_t triangles = 0;
  for (const Visual& visual : model.visuals) {
    const std::string& name = visual.name.empty() ? visual.link : visual.name;
    Shape shape{.name = name, .geometry = {}, .pose = visual.pose, .surface = {}};
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
  if (triangles == 0 && !has_wings) shapes.clear();
  return shapes;
}

std::vector<Shape> drawn_world(const WorldModel& world) {
  std::vector<Shape> shapes = world.statics;
  if (world.terrain) {
    shapes.push_back(
        {.name = "terrain",
         .geometry = Mesh{std::make_shared<const TriangleMesh>(world.terrain->picture())},
         .pose = Eigen::Isometry3d::Identity(),
         .surface = {}});
  }
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
