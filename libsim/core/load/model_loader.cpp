// SPDX-License-Identifier: BSD-3-Clause
#include "libsim/core/load/model_loader.hpp"

#include <fmt/format.h>
#include <optional>
#include <utility>

#include "base/config/model_body.hpp"
#include "base/config/model_uri.hpp"
#include "base/error.hpp"
#include "base/text.hpp"
#include "libsim/core/load/mesh_file.hpp"

namespace cas::sim {

namespace {

[[noreturn]] void fail(const std::filesystem::path& file, const std::string& sentence) {
  throw base::ConfigError(file.string() + ": " + sentence);
}

Eigen::Vector3d size_of(const Geometry& geometry) {
  if (const auto* box = std::get_if<Box>(&geometry)) return box->size_m;
  if (const auto* ball = std::get_if<Sphere>(&geometry)) {
    return Eigen::Vector3d::Constant(ball->radius_m);
  }
  const auto& cylinder = std::get<Cylinder>(geometry);
  return {cylinder.radius_m, cylinder.radius_m, cylinder.length_m};
}

bool has_extent(const Geometry& geometry) {
  const Eigen::Vector3d size_m = size_of(geometry);
  return size_m.allFinite() && (size_m.array() > 0).all();
}

/// The beginning of a sentence about a shape.
std::string place_of(const base::ModelShape& shape) {
  return shape.place + ": link '" + shape.link + "': ";
}

/// The contact solver knows no body without extent.
void check_size(const base::ModelShape& shape, const Geometry& geometry) {
  if (has_extent(geometry)) return;
  throw base::ConfigError(place_of(shape) +
                          "a <collision> geometry has a size that is not above 0");
}

/// Far from the origin the contact solver has too few digits left.
void check_reach(const base::ModelShape& from, const Shape& shape) {
  constexpr double kFarthest_m = 1000;
  const double reach_m = bounding_radius(shape);
  if (reach_m <= kFarthest_m) return;
  throw base::ConfigError(fmt::format(
      "{}a <collision> reaches {:.3g} m from the model's origin, and at most {:g} m can touch the "
      "ground; lengths are in m",
      place_of(from), reach_m, kFarthest_m));
}

/// A mesh's bounding box; its centre moves the shape's pose.
void take_as_box(const TriangleMesh& mesh, Shape& shape) {
  constexpr double kThinnest = 1e-3;  // a flat part still needs a thickness to collide
  Eigen::Vector3d centre;
  const Box box = bounding_box(mesh, centre);
  shape.geometry = Box{box.size_m.cwiseMax(kThinnest)};
  shape.pose.translate(centre);
}

/// The mesh of a collision. What is said about the file names the link, too.
TriangleMesh read_mesh(const std::filesystem::path& file, const base::ModelShape& from,
                       VehicleModel& model) {
  const std::string who = "; it is a <collision> of link '" + from.link + "', " + from.place;
  std::vector<std::string> notes;
  try {
    TriangleMesh mesh = load_mesh(file, from.size, {.up_axis = model.up_axis, .warnings = &notes});
    for (const std::string& note : notes) model.warnings.push_back(note + who);
    return mesh;
  } catch (const base::ConfigError& error) {
    throw base::ConfigError(error.what() + who);
  }
}

/// For an error that some of them may explain.
std::string all_of(const std::vector<std::string>& warnings) {
  return base::joined(warnings, "", [](const std::string& each) { return "; " + each; });
}

void require_shapes(const std::filesystem::path& file, const VehicleModel& model) {
  if (!model.shapes.empty()) return;
  fail(file, "has no <collision> geometry: the vehicle would fall through the ground" +
                 all_of(model.warnings));
}

/// The shapes of a model file; mass, places and axes are base::ModelBody's.
class ShapeReader {
 public:
  ShapeReader(const base::ModelBody& body, UpAxis up_axis) : body_(body) {
    model_.up_axis = up_axis;
  }

  VehicleModel run() {
    take_mass();
    for (const base::ModelLink& link : body_.links) {
      if (!link.axis_R) continue;
      model_.rotors.push_back({link.joint, body_.position_B_m(link), *link.axis_R});
    }
    for (const base::ModelShape& shape : body_.shapes) {
      if (!shape.visual) take_collision(shape);
      if (shape.visual && !shape.turns) take_visual(shape);
    }
    require_shapes(body_.file, model_);
    for (Shape& shape : model_.shapes) shape.pose.pretranslate(-body_.cog_R_m);
    for (Visual& visual : model_.visuals) visual.pose.pretranslate(-body_.cog_R_m);
    return std::move(model_);
  }

 private:
  void take_mass() {
    if (body_.mass_kg <= 0) fail(body_.file, "no link has an <inertial> with a mass");
    if (!base::is_physical_inertia(body_.inertia_B_kg_m2)) {
      fail(body_.file, "the vehicle's inertia about its centre of gravity is not that of a body" +
                           all_of(body_.warnings));
    }
    model_.name = body_.name;
    model_.mass = MassProperties(body_.mass_kg, body_.inertia_B_kg_m2);
    model_.cog_in_root_m = body_.cog_R_m;
    model_.warnings = body_.warnings;
  }

  void take_collision(const base::ModelShape& from) {
    Shape shape;
    shape.name = from.link;
    shape.pose = from.X_RS;
    if (const auto solid = solid_of(from)) {
      check_size(from, *solid);
      shape.geometry = *solid;
    } else if (from.form == base::ModelShape::Form::kMesh) {
      const auto found = find_mesh(from);
      if (!found) throw base::ConfigError(place_of(from) + missing_mesh(from));
      take_as_box(read_mesh(*found, from, model_), shape);
    } else {
      model_.warnings.push_back(place_of(from) + "a <" + from.word +
                                "> collision is left out; boxes, spheres, cylinders and meshes "
                                "touch the ground");
      return;
    }
    check_reach(from, shape);
    model_.shapes.push_back(std::move(shape));
  }

  /// A visual that cannot be drawn is left out: the flight does not need it.
  void take_visual(const base::ModelShape& from) {
    if (const auto solid = solid_of(from)) {
      if (has_extent(*solid)) {
        model_.visuals.push_back({from.link, from.name, *solid, from.X_RS});
      } else {
        leave_out_visual(from, "it has a size that is not above 0");
      }
    } else if (from.form != base::ModelShape::Form::kMesh) {
      leave_out_visual(from, "a <" + from.word + "> is not drawn");
    } else if (const auto mesh = find_mesh(from); !mesh) {
      leave_out_visual(from, missing_mesh(from));
    } else if (const auto refusal = mesh_kind_refusal(*mesh)) {
      leave_out_visual(from, *refusal);
    } else {
      model_.visuals.push_back({from.link, from.name, MeshFile{*mesh, from.size}, from.X_RS});
    }
  }

  void leave_out_visual(const base::ModelShape& from, const std::string& why) {
    model_.warnings.push_back(place_of(from) + "this <visual> is left out: " + why);
  }

  static std::string missing_mesh(const base::ModelShape& from) {
    return "mesh '" + from.uri + "' is nowhere to be found; looked for it at " +
           base::searched_places(from.uri, from.file.parent_path(), {});
  }

  static std::optional<std::filesystem::path> find_mesh(const base::ModelShape& from) {
    if (from.form != base::ModelShape::Form::kMesh) return std::nullopt;
    return base::find_model_file(from.uri, from.file.parent_path(), {});
  }

  /// Nothing for a mesh or a form that is not known.
  static std::optional<Geometry> solid_of(const base::ModelShape& from) {
    switch (from.form) {
      case base::ModelShape::Form::kBox:
        return Box{from.size};
      case base::ModelShape::Form::kSphere:
        return Sphere{from.size.x()};
      case base::ModelShape::Form::kCylinder:
        return Cylinder{from.size.x(), from.size.z()};
      default:
        return std::nullopt;
    }
  }

  const base::ModelBody& body_;
  VehicleModel model_;
};

}  // namespace

VehicleModel load_vehicle_model(const std::filesystem::path& file, const base::ModelParts& parts,
                                UpAxis up_axis) {
  const auto body = base::read_model_body(file, parts);
  if (!body) fail(file, "there is no such file; key 'urdf' or 'sdf' of a vehicle names it");
  return ShapeReader(*body, up_axis).run();
}

VehicleModel load_vehicle_model(const std::filesystem::path& file) {
  return load_vehicle_model(file, {});
}

}  // namespace cas::sim
