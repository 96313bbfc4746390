// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <utility>

#include "base/config/install_paths.hpp"
#include "base/config/model_uri.hpp"
#include "base/config/xml_tree.hpp"
#include "base/error.hpp"
#include "libsim/core/load/heightmap.hpp"
#include "libsim/core/load/mesh_file.hpp"
#include "libsim/core/load/sdf_environment.hpp"
#include "libsim/core/load/sdf_extent.hpp"
#include "libsim/core/load/sdf_geometry.hpp"
#include "libsim/core/load/sdf_headers.hpp"
#include "libsim/core/load/sdf_missing.hpp"
#include "libsim/core/load/sdf_numbers.hpp"
#include "libsim/core/load/sdf_omissions.hpp"
#include "libsim/core/load/sdf_refusal.hpp"
#include "libsim/core/load/sdf_world.hpp"

namespace cas::sim {

namespace {

namespace fs = std::filesystem;

/// Where a part stands if not in its parent; empty for most.
template <class Part>
std::string frame_of(const Part& part) {
  if (!part.PoseRelativeTo().empty()) return part.PoseRelativeTo();
  if constexpr (requires { part.PlacementFrameName(); }) return part.PlacementFrameName();
  return "";
}

/// Pose of a part in its parent. Without a frame of its own it is the pose in the file, whether or
/// not libsdformat makes sense of the joints around it.
template <class Part>
Eigen::Isometry3d pose_of(const Part& part) {
  ignition::math::Pose3d pose = part.RawPose();
  if (!part.SemanticPose().Resolve(pose).empty() && !frame_of(part).empty()) {
    throw base::ConfigError(place_of(*part.Element()) + ": <" + part.Element()->GetName() +
                            " name='" + part.Name() + "'> stands in the frame '" + frame_of(part) +
                            "', which is nowhere to be found");
  }
  return to_eigen(pose);
}

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
         (error.LineNumber() ? fmt::format(":{}", *error.LineNumber()) : "");
}

bool is_missing_model(const sdf::Error& error) {
  return error.Code() == sdf::ErrorCode::URI_LOOKUP;
}

/// Second elements of a name are sdf_omissions()'s; a prefix of an attribute is another program's;
/// the sum of all errors says nothing.
bool is_told_elsewhere(const sdf::Error& error) {
  return error.Code() == sdf::ErrorCode::DUPLICATE_NAME ||
         error.Message() == "Failed to load a world." ||
         (error.Code() == sdf::ErrorCode::ATTRIBUTE_INCORRECT_TYPE &&
          (error.Message().find(':') != std::string::npos ||
           error.Message().find("[xmlns]") != std::string::npos));
}

/// A warning about a mesh of many small triangles, which make steps slow; nullopt for other meshes.
std::optional<std::string> fine_triangles(const TriangleMesh& mesh) {
  constexpr double kFine_m = 0.05;     // hundreds lie below a vehicle: a step takes a millisecond
  constexpr std::size_t kFew = 5'000;  // fewer are a small object
  const std::size_t count = mesh.triangles.size();
  if (count < kFew) return std::nullopt;
  double area = 0;
  for (const auto& [a, b, c] : mesh.triangles) {
    const Eigen::Vector3d side = mesh.vertices[b] - mesh.vertices[a];
    area += 0.5 * side.cross(mesh.vertices[c] - mesh.vertices[a]).norm();
  }
  const double wide_m = std::sqrt(2 * area / static_cast<double>(count));  // as halves of squares
  if (wide_m >= kFine_m) return std::nullopt;
  return fmt::format(
      "its {} triangles are about {:.2g} cm wide: where they are not flat, a vehicle that "
      "touches them costs milliseconds a step; 10 cm are fine enough",
      count, 100 * wide_m);
}

std::string one_line(std::string text) {
  std::ranges::replace(text, '\n', ' ');
  return std::string(base::without_space(text));
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
  /// @param missing  of the included files
  Translator(const WorldConfig& config, const std::vector<fs::path>& model_path,
             std::vector<MissingFile> missing)
      : config_(config),
        file_(*config.sdf),
        model_path_(model_path),
        missing_(std::move(missing)) {}

  /// Warns of what libsdformat complains of. Of errors without a line three are named: joints that
  /// do not resolve come by the dozen.
  void take_errors(const sdf::Errors& errors) {
    constexpr std::size_t kNamed = 3;
    std::set<std::string> others;
    for (const sdf::Error& error : errors) {
      if (is_missing_model(error)) {
        const std::string uri = uri_in(error.Message());
        missing_.push_back(
            {"model " + uri, place_of_error(error, file_), uri, file_.parent_path()});
      } else if (is_told_elsewhere(error)) {
        continue;
      } else if (error.LineNumber() ||
                 (others.insert(error.Message()).second && others.size() <= kNamed)) {
        warn(place_of_error(error, file_), one_line(error.Message()));
      }
    }
    if (others.size() > kNamed) {
      warn(file_.string(),
           fmt::format("libsdformat has {} further complaints", others.size() - kNamed));
    }
  }

  /// Models and meshes that were not found, in the order of the file.
  const std::vector<MissingFile>& missing() const { return missing_; }

  WorldModel run(const sdf::World& world) {
    model_.name = world.Name();
    take_sdf_environment(world, model_);
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
    const std::string place = place_of(*collision.Element());
    Shape shape;
    shape.name = owner + "/" + collision.Name();
    shape.pose = X * pose_of(collision);
    if (!is_within(shape.pose.translation().norm(), 0, kLargest_m)) {
      throw base::ConfigError(place + ": collision '" + shape.name +
                              "': its <pose> is not finite, or more than 1e8 m away");
    }
    shape.surface = sdf_surface(collision, shape.name, model_.warnings);
    if (!take_geometry(*collision.Geom(), place, shape)) return std::nullopt;
    return shape;
  }

  /// An actor with collisions and a trajectory is an obstacle on its way.
  void take_actor(const sdf::Actor& actor) {
    const std::string place = place_of(*actor.Element());
    std::vector<Shape> shapes = shapes_of(actor, place);
    std::vector<Waypoint> waypoints = waypoints_of(actor, place);
    if (shapes.empty()) {
      return warn(place, "<actor name='" + actor.Name() +
                             "'> has no <collision> that can be touched: it is a picture, and left "
                             "out");
    }
    if (!actor.PoseRelativeTo().empty()) {
      warn(place, "<actor name='" + actor.Name() +
                      "'>: its <pose> is taken in the world, not in '" + actor.PoseRelativeTo() +
                      "'");
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

  /// Waypoints of the actor's first trajectory; poses are relative to the actor's own.
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
      if (!is_within(waypoints.back().pose.translation().norm(), 0, kLargest_m)) {
        throw base::ConfigError(place + ": " + who + "a <pose> of its way is not finite");
      }
    }
    return waypoints;
  }

  /// @param place  of the collision, for warnings
  bool take_geometry(const sdf::Geometry& geometry, const std::string& place, Shape& shape) {
    switch (geometry.Type()) {
      case sdf::GeometryType::MESH:
        return take_mesh(*geometry.MeshShape(), place, shape);
      case sdf::GeometryType::HEIGHTMAP:
        return take_heightmap(*geometry.HeightmapShape(), place, shape);
      default:
        return take_sdf_primitive(geometry, place + ": collision '" + shape.name + "'", shape);
    }
  }

  bool take_mesh(const sdf::Mesh& mesh, const std::string& place, Shape& shape) {
    const Eigen::Vector3d scale = to_eigen(mesh.Scale());
    const std::string who = place + ": collision '" + shape.name + "'";
    if (!(scale.cwiseAbs().minCoeff() > 0)) {
      throw base::ConfigError(who + ": the <scale> of a <mesh> must not be 0");
    }
    return take_triangles(
        {"mesh", mesh.Uri(), mesh.FilePath(), scale}, place, shape, [&](const fs::path& found) {
          std::vector<std::string> notes;
          TriangleMesh triangles =
              load_mesh(found, scale, {.up_axis = config_.up_axis, .warnings = &notes});
          for (const std::string& note : notes) warn(who, note);
          return triangles;
        });
  }

  bool take_heightmap(const sdf::Heightmap& map, const std::string& place, Shape& shape) {
    const Eigen::Vector3d size = to_eigen(map.Size());
    const Eigen::Vector3d offset = to_eigen(map.Position());
    if (!is_within(size.x(), kSmallest_m, kLargest_m) ||
        !is_within(size.y(), kSmallest_m, kLargest_m) || !is_within(size.z(), 0, kLargest_m) ||
        !is_within(offset.norm(), 0, kLargest_m)) {
      throw base::ConfigError(place + ": collision '" + shape.name +
                              "': a <heightmap> needs a <size> above 0 (its height may be 0) and "
                              "a <pos> within 1e8 m");
    }
    return take_triangles(
        {"heightmap", map.Uri(), map.FilePath(), size, offset}, place, shape,
        [&](const fs::path& found) { return load_heightmap(found, size, offset); });
  }

  template <class Load>
  bool take_triangles(const MeshUse& use, const std::string& place, Shape& shape,
                      const Load& load) {
    const fs::path folder = (use.named_in.empty() ? file_ : use.named_in).parent_path();
    const auto found = base::find_model_file(use.uri, folder, model_path_);
    if (!found) {
      missing_.push_back({use.kind + " " + use.uri, place, use.uri, folder});
      return false;
    }
    auto& mesh = meshes_[*found][std::pair(numbers(use.size_m), numbers(use.offset_m))];
    try {
      if (!mesh) {
        mesh = std::make_shared<const TriangleMesh>(load(*found));
        triangles_ += mesh->triangles.size();
        if (const auto note = fine_triangles(*mesh)) {
          warn(place, "collision '" + shape.name + "': " + *note);
        }
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
    throw base::ConfigError(
        fmt::format("{}: with this mesh the world has {} triangles, and at "
                    "most {} are simulated; make the meshes coarser",
                    place, triangles_, kMostTriangles));
  }

  void warn(const std::string& place, const std::string& sentence) {
    std::string line = place + ": " + sentence;
    if (warned_.insert(line).second) model_.warnings.push_back(std::move(line));
  }

  const WorldConfig& config_;
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

/// Included files are read as libsdformat's global configuration has it, whoever reads the file
/// that includes them.
class GlobalParser {
 public:
  explicit GlobalParser(const sdf::ParserConfig& parser) { current() = parser; }
  ~GlobalParser() { current() = before_; }
  GlobalParser(const GlobalParser&) = delete;
  GlobalParser& operator=(const GlobalParser&) = delete;

 private:
  static sdf::ParserConfig& current() { return sdf::ParserConfig::GlobalConfig(); }

  const sdf::ParserConfig before_ = current();
};

/// libsdformat throws for some damage, too. @param description  is filled
sdf::Errors load_root(const fs::path& file, const sdf::ParserConfig& parser,
                      const sdf::SDFPtr& description, sdf::Root& root) {
  try {
    sdf::Errors errors;
    if (!sdf::readFile(file.string(), parser, description, errors)) return errors;
    const sdf::Errors more = root.Load(description, parser);
    errors.insert(errors.end(), more.begin(), more.end());
    return errors;
  } catch (const std::exception& error) {
    throw base::ConfigError(file.string() + ": libsdformat cannot read it: " + error.what());
  }
}

}  // namespace

void cas_load_sdf_world(const WorldConfig& config, WorldModel& model) {
  const fs::path& file = *config.sdf;
  std::vector<fs::path> model_path = config.model_path;
  model_path.push_back(file.parent_path() / "models");
  for (const fs::path& dir : base::config_dirs()) model_path.push_back(dir / "worlds/models");
  sdf::Console::Instance()->SetQuiet(true);  // it returns the same messages as errors
  const auto find = [&](const std::string& uri, const fs::path& folder) {
    return base::find_model_file(uri, folder, model_path);
  };
  const SdfContents contents = require_readable_extent(file, find);
  sdf::ParserConfig parser;
  parser.SetFindCallback([&](const std::string& word) {
    const std::string uri(base::without_space(word));
    const auto known = contents.included.find(uri);
    if (known != contents.included.end()) return known->second.string();
    return find(uri, file.parent_path()).value_or("").string();  // its text has entities
  });
  const GlobalParser for_includes(parser);  // it prints their warnings, if they are errors
  parser.SetWarningsPolicy(sdf::EnforcementPolicy::ERR);
  parser.SetDeprecatedElementsPolicy(sdf::EnforcementPolicy::WARN);
  sdf::Root root;
  const sdf::Errors errors = load_root(file, parser, contents.description.sdf(), root);
  if (root.WorldCount() == 0) refuse_sdf(file, errors);
  const sdf::World& world = *root.WorldByIndex(0);
  require_whole_numbers(world.Element());
  Translator translator(config, model_path, contents.missing);
  translator.take_errors(errors);
  model = translator.run(world);
  for (std::uint64_t i = 1; i < root.WorldCount(); ++i) {
    const sdf::World& other = *root.WorldByIndex(i);
    model.warnings.push_back(place_of(*other.Element()) + ": the <world> '" + other.Name() +
                             "' is left out: the first of a file is flown in, '" + model.name +
                             "'");
  }
  require_all(translator.missing(), config, model_path, model);
}

}  // namespace cas::sim
