// SPDX-License-Identifier: BSD-3-Clause
#include <array>
#include <cmath>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string_view>
#include <utility>

#include "base/config/install_paths.hpp"
#include "base/config/xml_tree.hpp"
#include "base/error.hpp"
#include "base/read_file.hpp"
#include "libsim/core/load/heightmap.hpp"
#include "libsim/core/load/mesh_file.hpp"
#include "libsim/core/load/sdf_headers.hpp"
#include "libsim/core/load/sdf_omissions.hpp"
#include "libsim/core/load/sdf_world.hpp"
#include "libsim/core/load/uri.hpp"

namespace cas::sim {

using base::parse_xml;
using base::template_language;
using base::XmlElement;

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

/// Pose of a part in its parent; if unresolvable, the pose in the file.
template <class Part>
Eigen::Isometry3d pose_of(const Part& part) {
  ignition::math::Pose3d pose = part.RawPose();
  part.SemanticPose().Resolve(pose);
  return to_eigen(pose);
}

/// A model or mesh that is nowhere to be found.
struct MissingFile {
  std::string what;   ///< "model model://oak_tree"
  std::string place;  ///< FILE:LINE of the reference
  std::string uri;
};

/// Most triangles of all meshes of a world, each counted once however often it occurs. They take up
/// to a gigabyte.
constexpr std::size_t kMostTriangles = 5'000'000;

using Numbers = std::array<double, 3>;

Numbers numbers(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }

/// A mesh or heightmap as a collision names it.
struct MeshUse {
  std::string kind;
  std::string uri;
  fs::path named_in;  ///< the file that names `uri`
  Eigen::Vector3d size_m;
  Eigen::Vector3d offset_m = Eigen::Vector3d::Zero();
};

std::string place_of_error(const sdf::Error& error, const fs::path& file) {
  return error.FilePath().value_or(file.string()) +
         (error.LineNumber() ? ":" + std::to_string(*error.LineNumber()) : "");
}

/// A child that the file has, not a default that libsdformat adds.
sdf::ElementPtr set_child(const sdf::ElementPtr& element, const std::string& name) {
  if (!element || !element->HasElement(name)) return nullptr;
  sdf::ElementPtr found = element->GetElement(name);
  return found->GetExplicitlySetInFile() ? found : nullptr;
}

bool is_missing_model(const sdf::Error& error) {
  return error.Code() == sdf::ErrorCode::URI_LOOKUP;
}

/// "Unable to find uri[model://x]": the URI; else the whole sentence.
std::string uri_in(const std::string& message) {
  const std::size_t begin = message.find("uri[");
  if (begin == std::string::npos) return message;
  const std::size_t end = message.find(']', begin);
  return message.substr(begin + 4, end - begin - 4);
}

/// Turns the DOM into a WorldModel; names omitted parts.
class Translator {
 public:
  Translator(const fs::path& file, const std::vector<fs::path>& model_path)
      : file_(file), model_path_(model_path) {}

  /// Names three of libsdformat's errors: joints that do not resolve come by the dozen.
  void take_errors(const sdf::Errors& errors) {
    constexpr std::size_t kNamed = 3;
    std::set<std::string> others;
    for (const sdf::Error& error : errors) {
      if (is_missing_model(error)) {
        const std::string uri = uri_in(error.Message());
        missing_.push_back({"model " + uri, place_of_error(error, file_), uri});
      } else if (others.insert(error.Message()).second && others.size() <= kNamed) {
        warn(place_of_error(error, file_), error.Message());
      }
    }
    if (others.size() > kNamed) {
      warn(file_.string(),
           "libsdformat has " + std::to_string(others.size() - kNamed) + " further complaints");
    }
  }

  /// Models and meshes that were not found, in the order of the file.
  const std::vector<MissingFile>& missing() const { return missing_; }

  WorldModel run(const sdf::World& world) {
    model_.name = world.Name();
    model_.gravity_W = to_eigen(world.Gravity());
    model_.wind_W = to_eigen(world.WindLinearVelocity());
    take_physics(world);
    take_home(world);
    take_magnetic_field(world.Element());
    take_atmosphere(world);
    for (std::uint64_t i = 0; i < world.ModelCount(); ++i) {
      take_model(*world.ModelByIndex(i), Eigen::Isometry3d::Identity());
    }
    for (std::uint64_t i = 0; i < world.ActorCount(); ++i) take_actor(*world.ActorByIndex(i));
    for (std::string& sentence : sdf_omissions(world.Element())) {
      model_.warnings.push_back(std::move(sentence));
    }
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
      warn(place_of(*physics->Element()), "<max_step_size> must lie in [0.0001, 0.01] s; left out");
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
      warn(place_of(*world.Element()->GetElement("spherical_coordinates")),
           "<heading_deg> is left out: x is east here");
    }
  }

  /// SDF has it in tesla, in the axes of <spherical_coordinates>: those of W. Where it is not in
  /// the file the Earth's field is taken, not SDF's default.
  void take_magnetic_field(const sdf::ElementPtr& world) {
    sdf::ElementPtr field = set_child(world, "magnetic_field");
    if (!field) field = set_child(set_child(world, "physics"), "magnetic_field");  // SDF 1.5
    if (!field) return;
    const Eigen::Vector3d field_T = to_eigen(field->Get<ignition::math::Vector3d>());
    constexpr double kMost_T = 1e-3;  // twenty times the Earth's: sensors end there
    constexpr double kGaussPerTesla = 1e4;
    if (field_T.allFinite() && field_T.norm() <= kMost_T) {
      model_.magnetic_field_W = kGaussPerTesla * field_T;
    } else {
      warn(place_of(*field), "<magnetic_field> must lie in [0, 0.001] T; left out");
    }
  }

  /// Temperature, its gradient and pressure at sea level; SDF knows no other kind of air.
  void take_atmosphere(const sdf::World& world) {
    const sdf::Atmosphere* const air = world.Atmosphere();
    const sdf::ElementPtr element = set_child(world.Element(), "atmosphere");
    if (air == nullptr || !element) return;
    const base::Atmosphere wanted{.temperature_K = air->Temperature().Kelvin(),
                                  .temperature_gradient_K_m = air->TemperatureGradient(),
                                  .pressure_Pa = air->Pressure()};
    const auto within = [](double value, double low, double high) {
      return value >= low && value <= high;
    };
    if (within(wanted.temperature_K, 150, 400) && within(wanted.pressure_Pa, 1'000, 200'000) &&
        within(wanted.temperature_gradient_K_m, -0.05, 0.05)) {
      model_.atmosphere = wanted;
    } else {
      warn(place_of(*element),
           "<atmosphere>: <temperature> must lie in [150, 400] K, <temperature_gradient> in "
           "[-0.05, 0.05] K/m, <pressure> in [1000, 200000] Pa; left out");
    }
  }

  void take_model(const sdf::Model& model, const Eigen::Isometry3d& X_WP) {
    const Eigen::Isometry3d X_WM = X_WP * pose_of(model);
    for (std::uint64_t i = 0; i < model.LinkCount(); ++i) {
      const sdf::Link& link = *model.LinkByIndex(i);
      const Eigen::Isometry3d X_WL = X_WM * pose_of(link);
      for (std::uint64_t c = 0; c < link.CollisionCount(); ++c) {
        take_collision(model, *link.CollisionByIndex(c), X_WL);
      }
    }
    for (std::uint64_t i = 0; i < model.ModelCount(); ++i) take_model(*model.ModelByIndex(i), X_WM);
  }

  void take_collision(const sdf::Model& model, const sdf::Collision& collision,
                      const Eigen::Isometry3d& X_WL) {
    if (auto shape = shape_of(model.Name(), collision, X_WL)) {
      model_.statics.push_back(std::move(*shape));
    }
  }

  /// @param X  of the link, in the frame of the result
  std::optional<Shape> shape_of(const std::string& owner, const sdf::Collision& collision,
                                const Eigen::Isometry3d& X) {
    if (!is_solid(collision)) return std::nullopt;
    Shape shape;
    shape.name = owner + "/" + collision.Name();
    shape.pose = X * pose_of(collision);
    shape.surface = surface_of(collision);
    if (!take_geometry(*collision.Geom(), place_of(*collision.Element()), shape)) {
      return std::nullopt;
    }
    return shape;
  }

  /// An actor with collisions and a trajectory is an obstacle on its way.
  void take_actor(const sdf::Actor& actor) {
    const std::string place = place_of(*actor.Element());
    std::vector<Shape> shapes = shapes_of(actor, place);
    std::vector<Waypoint> waypoints = waypoints_of(actor, place);
    if (shapes.empty()) {
      return warn(place, "<actor name='" + actor.Name() +
                             "'> has no <link> with a <collision>: it is a picture, and left out");
    }
    if (waypoints.empty()) waypoints.push_back({0, to_eigen(actor.RawPose())});
    model_.moving.push_back(
        {actor.Name(), std::move(shapes),
         ObstaclePath(std::move(waypoints), actor.ScriptLoop(), actor.ScriptDelayStart())});
  }

  std::vector<Shape> shapes_of(const sdf::Actor& actor, const std::string& place) {
    std::vector<Shape> shapes;
    for (std::uint64_t i = 0; i < actor.LinkCount(); ++i) {
      const sdf::Link& link = *actor.LinkByIndex(i);
      for (std::uint64_t c = 0; c < link.CollisionCount(); ++c) {
        auto shape = shape_of(actor.Name(), *link.CollisionByIndex(c), pose_of(link));
        if (!shape) continue;
        if (std::holds_alternative<Plane>(shape->geometry)) {
          warn(place, "collision '" + shape->name + "' is left out: a plane cannot move");
        } else {
          shapes.push_back(std::move(*shape));
        }
      }
    }
    return shapes;
  }

  /// Of the first trajectory; poses are relative to the actor's own.
  std::vector<Waypoint> waypoints_of(const sdf::Actor& actor, const std::string& place) {
    std::vector<Waypoint> waypoints;
    if (actor.TrajectoryCount() == 0 || !actor.ScriptAutoStart()) return waypoints;
    const std::string who = "<actor name='" + actor.Name() + "'>: ";
    if (actor.TrajectoryCount() > 1) warn(place, who + "only its first <trajectory> is driven");
    const sdf::Trajectory& way = *actor.TrajectoryByIndex(0);
    for (std::uint64_t i = 0; i < way.WaypointCount(); ++i) {
      const sdf::Waypoint& point = *way.WaypointByIndex(i);
      const bool rises = waypoints.empty() || point.Time() > waypoints.back().time_s;
      if (!rises || !std::isfinite(point.Time())) {
        throw base::ConfigError(place + ": " + who + "the <time> of its waypoints must rise");
      }
      waypoints.push_back({point.Time(), to_eigen(actor.RawPose()) * to_eigen(point.Pose())});
    }
    return waypoints;
  }

  /// @param place  of the collision, for warnings
  bool take_geometry(const sdf::Geometry& geometry, const std::string& place, Shape& shape) {
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
        return take_mesh(*geometry.MeshShape(), place, shape);
      case sdf::GeometryType::HEIGHTMAP:
        return take_heightmap(*geometry.HeightmapShape(), place, shape);
      default:
        return false;  // sdf_omissions() names it
    }
  }

  bool take_mesh(const sdf::Mesh& mesh, const std::string& place, Shape& shape) {
    const Eigen::Vector3d scale = to_eigen(mesh.Scale());
    return take_triangles({"mesh", mesh.Uri(), mesh.FilePath(), scale}, place, shape,
                          [&](const fs::path& found) { return load_mesh(found, scale); });
  }

  bool take_heightmap(const sdf::Heightmap& map, const std::string& place, Shape& shape) {
    const Eigen::Vector3d size = to_eigen(map.Size());
    const Eigen::Vector3d offset = to_eigen(map.Position());
    return take_triangles(
        {"heightmap", map.Uri(), map.FilePath(), size, offset}, place, shape,
        [&](const fs::path& found) { return load_heightmap(found, size, offset); });
  }

  template <class Load>
  bool take_triangles(const MeshUse& use, const std::string& place, Shape& shape,
                      const Load& load) {
    const fs::path folder = (use.named_in.empty() ? file_ : use.named_in).parent_path();
    const auto found = find_model_file(use.uri, folder, model_path_);
    if (!found) {
      missing_.push_back({use.kind + " " + use.uri, place, use.uri});
      return false;
    }
    auto& mesh = meshes_[*found][std::pair(numbers(use.size_m), numbers(use.offset_m))];
    try {
      if (!mesh) {
        mesh = std::make_shared<const TriangleMesh>(load(*found));
        triangles_ += mesh->triangles.size();
      }
    } catch (const base::ConfigError& error) {
      warn(place, "collision '" + shape.name + "' is left out: " + error.what());
      return false;
    }
    require_few_triangles(place);
    shape.geometry = Mesh{mesh};
    return true;
  }

  void require_few_triangles(const std::string& place) const {
    if (triangles_ <= kMostTriangles) return;
    throw base::ConfigError(place + ": with this mesh the world has " + std::to_string(triangles_) +
                            " triangles, and at most " + std::to_string(kMostTriangles) +
                            " are simulated; make the meshes coarser");
  }

  /// Whether a vehicle, which has all 16 bits, feels it.
  static bool is_solid(const sdf::Collision& collision) {
    sdf::ElementPtr element = collision.Element();
    for (const char* name : {"surface", "contact"}) {
      if (element) element = element->HasElement(name) ? element->GetElement(name) : nullptr;
    }
    if (!element) return true;
    constexpr unsigned kEveryBit = 0xFFFF;
    if (element->HasElement("collide_without_contact") &&
        element->Get<bool>("collide_without_contact")) {
      return false;
    }
    return !element->HasElement("collide_bitmask") ||
           (element->Get<unsigned>("collide_bitmask") & kEveryBit) != 0;
  }

  static Surface surface_of(const sdf::Collision& collision) {
    Surface surface;
    sdf::ElementPtr element = collision.Element();
    for (const char* name : {"surface", "friction", "ode"}) {
      if (element) element = element->HasElement(name) ? element->GetElement(name) : nullptr;
    }
    if (element && element->HasElement("mu")) surface.friction = element->Get<double>("mu");
    element = collision.Element();
    for (const char* name : {"surface", "contact", "ode"}) {
      if (element) element = element->HasElement(name) ? element->GetElement(name) : nullptr;
    }
    if (!element) return surface;
    const auto positive = [&](const char* name) -> std::optional<double> {
      if (!element->HasElement(name)) return std::nullopt;
      const double value = element->Get<double>(name);
      return value > 0 ? std::optional(value) : std::nullopt;
    };
    surface.stiffness_n_m = positive("kp");
    surface.damping_n_s_m = positive("kd");
    return surface;
  }

  void warn(const std::string& place, const std::string& sentence) {
    std::string line = place + ": " + sentence;
    if (warned_.insert(line).second) model_.warnings.push_back(std::move(line));
  }

  const fs::path& file_;
  const std::vector<fs::path>& model_path_;
  WorldModel model_;
  std::vector<MissingFile> missing_;
  std::set<std::string> warned_;
  // Many shapes of one mesh share its triangles: by file, size and offset.
  std::map<fs::path, std::map<std::pair<Numbers, Numbers>, std::shared_ptr<const TriangleMesh>>>
      meshes_;
  std::size_t triangles_ = 0;  ///< of meshes_
};

/// The first complaints with their lines.
std::string joined(const sdf::Errors& errors) {
  constexpr std::size_t kNamed = 3;
  std::string text;
  for (std::size_t i = 0; i < std::min(errors.size(), kNamed); ++i) {
    const auto line = errors[i].LineNumber();
    text += (i == 0 ? "" : "; ") + (line ? "line " + std::to_string(*line) + ": " : std::string()) +
            errors[i].Message();
  }
  return text.empty() ? "it has no <world>" : text;
}

constexpr const char* kMendIt =
    "; mend that place: a world is <sdf version='1.9'><world name='w'> ... </world></sdf>, as in "
    "config/worlds/village.sdf";

/// The file as a tree. @throws base::ConfigError with the line of the error and the remedy
XmlElement parse_or_explain(const std::string& text, const fs::path& file) {
  try {
    return parse_xml(text, file.string());
  } catch (const base::ConfigError& error) {
    throw base::ConfigError(error.what() + std::string(kMendIt));
  }
}

/// Why a file is no world, in a sentence that helps. The reader has refused it.
[[noreturn]] void explain(const fs::path& file, const sdf::Errors& errors) {
  const std::string text = base::read_file(file).value_or("");
  const auto no_world = [&](const std::string& sentence) {
    return base::ConfigError(file.string() + ": holds no SDF world: " + sentence);
  };
  if (const auto sentence = template_language(text)) throw no_world(*sentence);
  const XmlElement root = parse_or_explain(text, file);
  if (root.name == "robot") {
    throw no_world("it is a URDF; a vehicle file names one, a world is an SDF file");
  }
  if (root.name == "COLLADA") {
    throw no_world("it is a COLLADA mesh; a <model> of an SDF file may name it");
  }
  if (root.name != "sdf" && root.name != "gazebo") {
    throw no_world("its outermost element is <" + root.name + ">, not <sdf>");
  }
  if (const XmlElement* const model = root.child("model")) {
    throw no_world("it is the model '" + std::string(model->attribute("name")) +
                   "' alone; write a world around it: <sdf version='1.9'><world "
                   "name='w'><include><uri>" +
                   fs::absolute(file).string() + "</uri></include></world></sdf>");
  }
  throw no_world(joined(errors) + kMendIt);
}

/// Names the reference to each missing file, and the folders searched.
std::string sentence_of(const std::vector<MissingFile>& missing, const fs::path& file,
                        const std::vector<fs::path>& model_path) {
  std::string text = missing.front().place + ": ";
  for (const MissingFile& each : missing) {
    const bool first = &each == &missing.front();
    text += (first ? "" : ", ") + each.what + (first ? "" : " (" + each.place + ")");
  }
  text += missing.size() == 1 ? " is nowhere to be found" : " are nowhere to be found";
  text += missing.size() == 1 ? "; looked for it at " : "; looked for the first of them at ";
  bool first = true;
  for (const fs::path& place :
       places_of_model_file(missing.front().uri, file.parent_path(), model_path)) {
    text +=
        (std::exchange(first, false) ? "" : ", ") + fs::absolute(place).lexically_normal().string();
  }
  return text +
         ". Name its folder in 'model_path' or GZ_SIM_RESOURCE_PATH; 'missing: ignore' "
         "(--ignore-missing) goes without it";
}

void require_all(const std::vector<MissingFile>& missing, const fs::path& file,
                 const std::vector<fs::path>& model_path, Missing rule, WorldModel& model) {
  if (missing.empty()) return;
  if (rule == Missing::kError) throw base::ConfigError(sentence_of(missing, file, model_path));
  for (const MissingFile& each : missing) {
    model.warnings.push_back(each.place + ": " + each.what + " is nowhere to be found; left out");
  }
  if (model.statics.empty()) {
    throw base::ConfigError(file.string() + ": without " + missing.front().what +
                            " nothing is left that could carry a vehicle");
  }
}

}  // namespace

void cas_load_sdf_world(const fs::path& file, const std::vector<fs::path>& given_model_path,
                        Missing missing, WorldModel& model) {
  std::vector<fs::path> model_path = given_model_path;
  model_path.push_back(file.parent_path() / "models");
  for (const fs::path& dir : base::config_dirs()) model_path.push_back(dir / "worlds/models");
  base::open_foreign_file(file, "world");
  sdf::Console::Instance()->SetQuiet(true);  // it returns the same messages as errors
  sdf::ParserConfig parser;
  parser.SetFindCallback([&](const std::string& uri) {
    const auto found = find_model_file(uri, file.parent_path(), model_path);
    return found ? found->string() : std::string();
  });
  sdf::Root root;
  const sdf::Errors errors = root.Load(file.string(), parser);
  if (root.WorldCount() == 0) explain(file, errors);
  Translator translator(file, model_path);
  translator.take_errors(errors);
  model = translator.run(*root.WorldByIndex(0));
  for (std::uint64_t i = 1; i < root.WorldCount(); ++i) {
    const sdf::World& other = *root.WorldByIndex(i);
    model.warnings.push_back(place_of(*other.Element()) + ": the <world> '" + other.Name() +
                             "' is left out: the first of a file is flown in, '" + model.name +
                             "'");
  }
  require_all(translator.missing(), file, model_path, missing, model);
}

}  // namespace cas::sim
