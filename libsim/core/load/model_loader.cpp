// SPDX-License-Identifier: BSD-3-Clause
#include "libsim/core/load/model_loader.hpp"

#include <console_bridge/console.h>
#include <urdf_model/model.h>
#include <urdf_parser/urdf_parser.h>

#include <cmath>
#include <optional>
#include <set>
#include <utility>

#include "base/config/sdf_model.hpp"
#include "base/config/xml_tree.hpp"
#include "base/error.hpp"
#include "base/read_file.hpp"
#include "libsim/core/load/mesh_file.hpp"
#include "libsim/core/load/uri.hpp"

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

/// The contact solver knows no body without extent.
void check_size(const std::filesystem::path& file, const std::string& link,
                const Geometry& geometry) {
  if (has_extent(geometry)) return;
  fail(file, "link '" + link + "': a <collision> geometry has a size that is not above 0");
}

/// A mesh's bounding box; its centre moves the shape's pose.
void take_as_box(const TriangleMesh& mesh, Shape& shape) {
  constexpr double kThinnest = 1e-3;  // a flat part still needs a thickness to collide
  Eigen::Vector3d centre;
  const Box box = bounding_box(mesh, centre);
  shape.geometry = Box{box.size_m.cwiseMax(kThinnest)};
  shape.pose.translate(centre);
}

/// Of the meshes of a vehicle's collisions.
MeshOptions mesh_options(VehicleModel& model) {
  return {.up_axis = model.up_axis, .warnings = &model.warnings};
}

void require_shapes(const std::filesystem::path& file, const VehicleModel& model) {
  if (!model.shapes.empty()) return;
  fail(file, "has no <collision> geometry: the vehicle would fall through the ground");
}

/// Collects urdfdom's messages during its lifetime.
class UrdfMessages final : public console_bridge::OutputHandler {
 public:
  UrdfMessages() { console_bridge::useOutputHandler(this); }
  ~UrdfMessages() override { console_bridge::restorePreviousOutputHandler(); }
  void log(const std::string& text, console_bridge::LogLevel level, const char*, int) override {
    if (level >= console_bridge::CONSOLE_BRIDGE_LOG_ERROR && first_.empty()) first_ = text;
  }
  const std::string& first() const { return first_; }

 private:
  std::string first_;
};

Eigen::Isometry3d to_eigen(const urdf::Pose& pose) {
  const urdf::Rotation& q = pose.rotation;
  Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
  X.translation() = Eigen::Vector3d(pose.position.x, pose.position.y, pose.position.z);
  X.linear() = Eigen::Quaterniond(q.w, q.x, q.y, q.z).normalized().toRotationMatrix();
  return X;
}

/// Nothing for a mesh.
std::optional<Geometry> solid_of(const urdf::Geometry& geometry) {
  switch (geometry.type) {
    case urdf::Geometry::BOX: {
      const auto& dim = static_cast<const urdf::Box&>(geometry).dim;
      return Box{{dim.x, dim.y, dim.z}};
    }
    case urdf::Geometry::SPHERE:
      return Sphere{static_cast<const urdf::Sphere&>(geometry).radius};
    case urdf::Geometry::CYLINDER: {
      const auto& cylinder = static_cast<const urdf::Cylinder&>(geometry);
      return Cylinder{cylinder.radius, cylinder.length};
    }
    case urdf::Geometry::MESH:
      break;
  }
  return std::nullopt;
}

/// Mass, first moment and inertia about the root's origin, summed over links.
struct MassSum {
  double mass = 0;
  Eigen::Vector3d moment = Eigen::Vector3d::Zero();
  Eigen::Matrix3d inertia = Eigen::Matrix3d::Zero();

  void add(double m, const Eigen::Vector3d& p, const Eigen::Matrix3d& inertia_about_own_cog) {
    mass += m;
    moment += m * p;
    inertia += inertia_about_own_cog + parallel_axis(m, p);
  }
  static Eigen::Matrix3d parallel_axis(double m, const Eigen::Vector3d& p) {
    return m * (p.squaredNorm() * Eigen::Matrix3d::Identity() - p * p.transpose());
  }
};

/// Walks the tree of links once.
class Assembler {
 public:
  Assembler(const std::filesystem::path& file, const urdf::ModelInterface& urdf, UpAxis up_axis)
      : file_(file), urdf_(urdf) {
    model_.up_axis = up_axis;
  }

  VehicleModel run() {
    model_.name = urdf_.getName();
    visit(*urdf_.getRoot(), Eigen::Isometry3d::Identity());
    finish_mass();
    require_shapes(file_, model_);
    return std::move(model_);
  }

 private:
  void visit(const urdf::Link& link, const Eigen::Isometry3d& X_RL) {
    add_mass(link, X_RL);
    for (const auto& collision : link.collision_array) add_shape(link, *collision, X_RL);
    for (const auto& visual : link.visual_array) add_visual(link, *visual, X_RL);
    for (const auto& joint : link.child_joints) {
      const Eigen::Isometry3d X_RJ = X_RL * to_eigen(joint->parent_to_joint_origin_transform);
      note_joint(*joint, X_RJ);
      visit(*urdf_.getLink(joint->child_link_name), X_RJ);
    }
  }

  void note_joint(const urdf::Joint& joint, const Eigen::Isometry3d& X_RJ) {
    if (joint.type == urdf::Joint::CONTINUOUS) {
      const Eigen::Vector3d axis(joint.axis.x, joint.axis.y, joint.axis.z);
      if (axis.norm() < 1e-9) fail(file_, "joint '" + joint.name + "': <axis> is zero");
      model_.rotors.push_back(
          {joint.name, X_RJ.translation(), (X_RJ.linear() * axis).normalized()});
    } else if (joint.type != urdf::Joint::FIXED) {
      warn("joint '" + joint.name +
           "' moves; only continuous joints (rotors) do here: taken as fixed");
    }
  }

  void add_mass(const urdf::Link& link, const Eigen::Isometry3d& X_RL) {
    if (!link.inertial) return;
    const urdf::Inertial& i = *link.inertial;
    if (!(i.mass >= 0) || !std::isfinite(i.mass)) {
      fail(file_, "link '" + link.name + "': <mass> must be positive");
    }
    const Eigen::Isometry3d X_RC = X_RL * to_eigen(i.origin);
    Eigen::Matrix3d inertia;
    inertia << i.ixx, i.ixy, i.ixz, i.ixy, i.iyy, i.iyz, i.ixz, i.iyz, i.izz;
    if (i.mass > 0 && !inertia.isZero(0) && !is_physical_inertia(inertia)) {
      warn("link '" + link.name + "': no body has this <inertia>; taken as a point mass");
      inertia.setZero();
    }
    sum_.add(i.mass, X_RC.translation(), X_RC.linear() * inertia * X_RC.linear().transpose());
  }

  void finish_mass() {
    if (sum_.mass <= 0) fail(file_, "no link has an <inertial> with a mass");
    const Eigen::Vector3d cog = sum_.moment / sum_.mass;
    Eigen::Matrix3d inertia = sum_.inertia - MassSum::parallel_axis(sum_.mass, cog);
    inertia = 0.5 * (inertia + inertia.transpose().eval());
    if (!is_physical_inertia(inertia)) {
      fail(file_, "the vehicle's inertia about its centre of gravity is not that of a body");
    }
    model_.mass = MassProperties(sum_.mass, inertia);
    model_.cog_in_root_m = cog;
    for (Shape& shape : model_.shapes) shape.pose.translation() -= cog;
    for (Visual& visual : model_.visuals) visual.pose.translation() -= cog;
    for (ModelRotor& rotor : model_.rotors) rotor.position_B_m -= cog;
  }

  void add_shape(const urdf::Link& link, const urdf::Collision& collision,
                 const Eigen::Isometry3d& X_RL) {
    if (!collision.geometry) return;
    Shape shape;
    shape.name = link.name;
    shape.pose = X_RL * to_eigen(collision.origin);
    if (const auto solid = solid_of(*collision.geometry)) {
      check_size(file_, link.name, *solid);
      shape.geometry = *solid;
    } else {
      take_mesh_as_box(link, static_cast<const urdf::Mesh&>(*collision.geometry), shape);
    }
    model_.shapes.push_back(std::move(shape));
  }

  void take_mesh_as_box(const urdf::Link& link, const urdf::Mesh& mesh, Shape& shape) {
    const auto found = find_model_file(mesh.filename, file_.parent_path(), {});
    if (!found) {
      fail(file_, "link '" + link.name + "': mesh '" + mesh.filename +
                      "' is nowhere to be found; looked for it at " +
                      searched_places(mesh.filename, file_.parent_path(), {}));
    }
    take_as_box(load_mesh(*found, {mesh.scale.x, mesh.scale.y, mesh.scale.z}, mesh_options(model_)),
                shape);
  }

  /// A visual that cannot be drawn is left out: the flight does not need it.
  void add_visual(const urdf::Link& link, const urdf::Visual& visual,
                  const Eigen::Isometry3d& X_RL) {
    const bool turns = link.parent_joint && link.parent_joint->type == urdf::Joint::CONTINUOUS;
    if (!visual.geometry || turns) return;
    const Eigen::Isometry3d X_RV = X_RL * to_eigen(visual.origin);
    if (const auto solid = solid_of(*visual.geometry)) {
      if (has_extent(*solid)) model_.visuals.push_back({link.name, *solid, X_RV});
      return;
    }
    const auto& mesh = static_cast<const urdf::Mesh&>(*visual.geometry);
    const auto found = find_model_file(mesh.filename, file_.parent_path(), {});
    if (!found) return;
    const MeshFile form{*found, {mesh.scale.x, mesh.scale.y, mesh.scale.z}};
    model_.visuals.push_back({link.name, form, X_RV});
  }

  void warn(const std::string& sentence) {
    model_.warnings.push_back(file_.string() + ": " + sentence);
  }

  const std::filesystem::path& file_;
  const urdf::ModelInterface& urdf_;
  MassSum sum_;
  VehicleModel model_;
};

/// The shapes of an SDF model; mass, places and axes are base::SdfModel's.
class SdfShapes {
 public:
  SdfShapes(const std::filesystem::path& file, const base::SdfModel& sdf, UpAxis up_axis)
      : file_(file), sdf_(sdf) {
    model_.up_axis = up_axis;
  }

  VehicleModel run() {
    const base::ModelBody body = sdf_.body();
    if (body.mass_kg <= 0) fail(file_, "no link has a mass");
    if (!is_physical_inertia(body.inertia_B_kg_m2)) {
      fail(file_, "the vehicle's inertia about its centre of gravity is not that of a body");
    }
    model_.name = sdf_.name();
    model_.mass = MassProperties(body.mass_kg, body.inertia_B_kg_m2);
    model_.cog_in_root_m = body.cog_R_m;
    std::set<std::string> turning;
    for (const base::ModelLink& link : body.links) {
      if (!link.axis_R) continue;
      turning.insert(link.name);
      model_.rotors.push_back({link.name, body.position_B_m(link), *link.axis_R});
    }
    for (const base::SdfLink& link : sdf_.links()) {
      for (const base::XmlElement& child : link.element->children) {
        if (child.name == "collision") take_collision(child, link);
        if (child.name == "visual" && !turning.contains(link.name)) take_visual(child, link);
      }
    }
    require_shapes(file_, model_);
    for (Shape& shape : model_.shapes) shape.pose.pretranslate(-body.cog_R_m);
    for (Visual& visual : model_.visuals) visual.pose.pretranslate(-body.cog_R_m);
    return std::move(model_);
  }

 private:
  void take_collision(const base::XmlElement& collision, const base::SdfLink& link) {
    const base::XmlElement* const geometry = collision.child("geometry");
    if (geometry == nullptr || geometry->children.empty()) return;
    Shape shape;
    shape.name = link.name;
    shape.pose = sdf_.pose_of(collision, link);
    const base::XmlElement& form = geometry->children.front();
    if (const auto solid = solid_of(form)) {
      check_size(file_, link.name, *solid);
      shape.geometry = *solid;
    } else if (form.name == "mesh") {
      take_mesh(form, shape);
    } else {
      model_.warnings.push_back(file_.string() + ":" + std::to_string(form.line) + ": link '" +
                                link.name + "': a <" + form.name +
                                "> collision is left out; boxes, spheres, cylinders and meshes "
                                "touch the ground");
      return;
    }
    model_.shapes.push_back(std::move(shape));
  }

  void take_mesh(const base::XmlElement& mesh, Shape& shape) {
    const base::XmlElement& uri = part(mesh, "uri");
    const auto found = find_mesh(mesh);
    if (!found) {
      sdf_.fail(uri, "mesh '" + uri.text + "' is nowhere to be found; looked for it at " +
                         searched_places(uri.text, file_.parent_path(), {}));
    }
    take_as_box(load_mesh(found->path, found->scale, mesh_options(model_)), shape);
  }

  std::optional<MeshFile> find_mesh(const base::XmlElement& mesh) const {
    auto found = find_model_file(part(mesh, "uri").text, file_.parent_path(), {});
    if (!found) return std::nullopt;
    MeshFile file{.path = *std::move(found)};
    if (const base::XmlElement* const scale = mesh.child("scale")) file.scale = sdf_.vector(*scale);
    return file;
  }

  /// Nothing for a form that is none of them.
  std::optional<Geometry> solid_of(const base::XmlElement& form) const {
    if (form.name == "box") return Box{sdf_.vector(part(form, "size"))};
    if (form.name == "sphere") return Sphere{sdf_.number(part(form, "radius"))};
    if (form.name == "cylinder") {
      return Cylinder{sdf_.number(part(form, "radius")), sdf_.number(part(form, "length"))};
    }
    return std::nullopt;
  }

  /// A visual that cannot be drawn is left out: the flight does not need it.
  void take_visual(const base::XmlElement& visual, const base::SdfLink& link) try {
    const base::XmlElement* const geometry = visual.child("geometry");
    if (geometry == nullptr || geometry->children.empty()) return;
    const base::XmlElement& form = geometry->children.front();
    const Eigen::Isometry3d X_RV = sdf_.pose_of(visual, link);
    if (const auto solid = solid_of(form)) {
      if (has_extent(*solid)) model_.visuals.push_back({link.name, *solid, X_RV});
    } else if (form.name == "mesh") {
      if (const auto mesh = find_mesh(form)) model_.visuals.push_back({link.name, *mesh, X_RV});
    }
  } catch (const base::ConfigError&) {
    // a size that is no number, say
  }

  const base::XmlElement& part(const base::XmlElement& form, std::string_view name) const {
    const base::XmlElement* const found = form.child(name);
    if (found == nullptr) sdf_.fail(form, "<" + form.name + "> has no <" + std::string(name) + ">");
    return *found;
  }

  const std::filesystem::path& file_;
  const base::SdfModel& sdf_;
  VehicleModel model_;
};

}  // namespace

bool is_physical_inertia(const Eigen::Matrix3d& inertia) {
  return base::is_physical_inertia(inertia);
}

VehicleModel load_vehicle_model(const std::filesystem::path& file, UpAxis up_axis) {
  const std::string text = base::read_foreign_file(file, "vehicle model", base::kMaxModelBytes);
  // A template may parse, without the expansion of its macros.
  if (const auto sentence = base::template_language(text))
    fail(file, "is not a URDF: " + *sentence);
  if (base::SdfModel::is_sdf(text)) {
    const base::SdfModel sdf(text, file);
    return SdfShapes(file, sdf, up_axis).run();
  }
  const UrdfMessages messages;
  const urdf::ModelInterfaceSharedPtr urdf = urdf::parseURDF(text);
  if (!urdf || !urdf->getRoot()) {
    base::parse_xml(text, file.string());  // broken XML ends here, with its line
    fail(file, "is not a URDF: " + (messages.first().empty() ? "no root link" : messages.first()));
  }
  return Assembler(file, *urdf, up_axis).run();
}

}  // namespace cas::sim
