// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <set>
#include <sstream>

#include "base/config/install_paths.hpp"
#include "base/error.hpp"
#include "libsim/core/load/mesh_file.hpp"
#include "libsim/core/load/sdf_headers.hpp"
#include "libsim/core/load/uri.hpp"
#include "libsim/core/load/world_loader.hpp"

namespace cas::sim {

namespace {

namespace fs = std::filesystem;

// As `step_us` of a configuration; with a step of zero time would stand still.
constexpr double kShortestStep_s = 1e-4;
constexpr double kLongestStep_s = 0.01;

Eigen::Vector3d to_eigen(const ignition::math::Vector3d& v) { return {v.X(), v.Y(), v.Z()}; }

Eigen::Isometry3d to_eigen(const ignition::math::Pose3d& pose) {
  Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
  const auto& q = pose.Rot();
  X.translation() = to_eigen(pose.Pos());
  X.linear() = Eigen::Quaterniond(q.W(), q.X(), q.Y(), q.Z()).normalized().toRotationMatrix();
  return X;
}

/// Pose of a part in its parent; an unresolvable one stands in the file as it is.
template <class Part>
Eigen::Isometry3d pose_of(const Part& part) {
  ignition::math::Pose3d pose = part.RawPose();
  part.SemanticPose().Resolve(pose);
  return to_eigen(pose);
}

/// Turns the DOM into a WorldModel; names once what it leaves out.
class Translator {
 public:
  Translator(const fs::path& file, const std::vector<fs::path>& model_path)
      : file_(file), model_path_(model_path) {}

  void take_errors(const sdf::Errors& errors) {
    for (const sdf::Error& error : errors) warn(error.Message());
  }

  WorldModel run(const sdf::World& world) {
    model_.name = world.Name();
    model_.gravity_W = to_eigen(world.Gravity());
    model_.wind_W = to_eigen(world.WindLinearVelocity());
    take_physics(world);
    take_home(world);
    for (std::uint64_t i = 0; i < world.ModelCount(); ++i) {
      take_model(*world.ModelByIndex(i), Eigen::Isometry3d::Identity());
    }
    note_unsupported(world);
    return std::move(model_);
  }

 private:
  void take_physics(const sdf::World& world) {
    const sdf::Physics* const physics = world.PhysicsDefault();
    // Without <physics> libsdformat makes one up.
    if (physics == nullptr || !world.Element()->HasElement("physics")) return;
    const double step_s = physics->MaxStepSize();
    if (step_s >= kShortestStep_s && step_s <= kLongestStep_s) {
      model_.step = base::from_seconds(step_s);
    } else {
      warn("<max_step_size> must lie in [0.0001, 0.01] s; left out");
    }
    if (physics->RealTimeFactor() > 0) model_.real_time_factor = physics->RealTimeFactor();
  }

  void take_home(const sdf::World& world) {
    const auto* const place = world.SphericalCoordinates();
    if (place == nullptr || !world.Element()->HasElement("spherical_coordinates")) return;
    model_.home = base::Geodetic{.lat_deg = place->LatitudeReference().Degree(),
                                 .lon_deg = place->LongitudeReference().Degree(),
                                 .alt_m = place->ElevationReference()};
    if (std::abs(place->HeadingOffset().Degree()) > 1e-9) {
      warn("<heading_deg> is not supported: x is east");
    }
  }

  void take_model(const sdf::Model& model, const Eigen::Isometry3d& X_WP) {
    const Eigen::Isometry3d X_WM = X_WP * pose_of(model);
    if (!model.Static()) warn_of("model", model.Name(), "is not static; it stands still here");
    if (model.JointCount() > 0) warn_of("model", model.Name(), "has joints; they are stiff here");
    for (std::uint64_t i = 0; i < model.LinkCount(); ++i) {
      const sdf::Link& link = *model.LinkByIndex(i);
      if (link.SensorCount() > 0) warn("<sensor> in worlds is left out: sensors are plugins");
      const Eigen::Isometry3d X_WL = X_WM * pose_of(link);
      for (std::uint64_t c = 0; c < link.CollisionCount(); ++c) {
        take_collision(model, *link.CollisionByIndex(c), X_WL);
      }
    }
    for (std::uint64_t i = 0; i < model.ModelCount(); ++i) take_model(*model.ModelByIndex(i), X_WM);
    if (model.Element()->HasElement("plugin")) warn("<plugin> in models is left out");
  }

  void take_collision(const sdf::Model& model, const sdf::Collision& collision,
                      const Eigen::Isometry3d& X_WL) {
    Shape shape;
    shape.name = model.Name() + "/" + collision.Name();
    shape.pose = X_WL * pose_of(collision);
    shape.surface = surface_of(collision);
    if (bounces(collision)) warn("<restitution_coefficient> is left out: nothing bounces");
    if (take_geometry(*collision.Geom(), shape)) model_.statics.push_back(std::move(shape));
  }

  bool take_geometry(const sdf::Geometry& geometry, Shape& shape) {
    switch (geometry.Type()) {
      case sdf::GeometryType::BOX:
        shape.geometry = Box{to_eigen(geometry.BoxShape()->Size())};
        return true;
      case sdf::GeometryType::SPHERE:
        shape.geometry = Sphere{geometry.SphereShape()->Radius()};
        return true;
      case sdf::GeometryType::CYLINDER:
        shape.geometry =
            Cylinder{geometry.CylinderShape()->Radius(), geometry.CylinderShape()->Length()};
        return true;
      case sdf::GeometryType::PLANE:
        shape.geometry = Plane{};
        shape.pose.rotate(Eigen::Quaterniond::FromTwoVectors(
            Eigen::Vector3d::UnitZ(), to_eigen(geometry.PlaneShape()->Normal())));
        return true;
      case sdf::GeometryType::MESH:
        return take_mesh(*geometry.MeshShape(), shape);
      default:
        warn_of("collision", shape.name,
                "has a geometry other than box, sphere, cylinder, plane and mesh; left out");
        return false;
    }
  }

  bool take_mesh(const sdf::Mesh& mesh, Shape& shape) {
    if (!mesh.Submesh().empty()) {
      warn_of("collision", shape.name, "names a <submesh>; the whole mesh collides here");
    }
    const fs::path folder =
        mesh.FilePath().empty() ? file_.parent_path() : fs::path(mesh.FilePath()).parent_path();
    const auto found = find_model_file(mesh.Uri(), folder, model_path_);
    if (!found) {
      warn_of("collision", shape.name, "names the mesh " + mesh.Uri() + ", which is not there");
      return false;
    }
    try {
      shape.geometry =
          Mesh{std::make_shared<const TriangleMesh>(load_mesh(*found, to_eigen(mesh.Scale())))};
      return true;
    } catch (const base::ConfigError& error) {
      warn_of("collision", shape.name, std::string("is left out: ") + error.what());
      return false;
    }
  }

  static bool bounces(const sdf::Collision& collision) {
    sdf::ElementPtr element = collision.Element();
    for (const char* name : {"surface", "bounce"}) {
      if (element) element = element->HasElement(name) ? element->GetElement(name) : nullptr;
    }
    return element && element->HasElement("restitution_coefficient") &&
           element->Get<double>("restitution_coefficient") > 0;
  }

  static Surface surface_of(const sdf::Collision& collision) {
    Surface surface;
    sdf::ElementPtr element = collision.Element();
    for (const char* name : {"surface", "friction", "ode"}) {
      if (element) element = element->HasElement(name) ? element->GetElement(name) : nullptr;
    }
    if (element && element->HasElement("mu")) surface.friction = element->Get<double>("mu");
    return surface;
  }

  void note_unsupported(const sdf::World& world) {
    if (world.ActorCount() > 0) warn("<actor> is left out");
    for (const char* name : {"plugin", "road", "state", "population", "joint"}) {
      if (world.Element()->HasElement(name)) {
        warn(std::string("<").append(name).append("> is left out"));
      }
    }
  }

  void warn_of(const std::string& kind, const std::string& name, const std::string& sentence) {
    warn(kind + " '" + name + "' " + sentence);
  }
  void warn(const std::string& sentence) {
    if (!warned_.insert(sentence).second) return;
    model_.warnings.push_back(file_.string() + ": " + sentence);
  }

  const fs::path& file_;
  const std::vector<fs::path>& model_path_;
  WorldModel model_;
  std::set<std::string> warned_;
};

std::string joined(const sdf::Errors& errors) {
  std::string text;
  for (const sdf::Error& error : errors) text += (text.empty() ? "" : "; ") + error.Message();
  return text.empty() ? "no reason given" : text;
}

}  // namespace

WorldModel load_sdf_world(const fs::path& file, const std::vector<fs::path>& given_model_path) {
  std::error_code error;
  std::vector<fs::path> model_path = given_model_path;
  model_path.push_back(file.parent_path() / "models");
  for (const fs::path& dir : base::config_dirs()) model_path.push_back(dir / "worlds/models");
  if (!fs::exists(file, error)) throw base::ConfigError(file.string() + ": world cannot be read");
  sdf::Console::Instance()->SetQuiet(true);  // what it would print comes back as errors
  sdf::ParserConfig parser;
  parser.SetFindCallback([&](const std::string& uri) {
    const auto found = find_model_file(uri, file.parent_path(), model_path);
    return found ? found->string() : std::string();
  });
  sdf::Root root;
  const sdf::Errors errors = root.Load(file.string(), parser);
  if (root.WorldCount() == 0) {
    throw base::ConfigError(file.string() + ": holds no SDF world: " + joined(errors));
  }
  Translator translator(file, model_path);
  translator.take_errors(errors);
  return translator.run(*root.WorldByIndex(0));
}

}  // namespace cas::sim
