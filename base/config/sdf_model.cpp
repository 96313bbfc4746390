// SPDX-License-Identifier: BSD-3-Clause
#include "base/config/sdf_model.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <deque>
#include <initializer_list>
#include <set>

#include "base/config/model_builder.hpp"
#include "base/config/model_motors.hpp"
#include "base/config/model_uri.hpp"
#include "base/config/sdf_elements.hpp"
#include "base/config/sdf_joints.hpp"
#include "base/config/sdf_scope.hpp"
#include "base/read_file.hpp"
#include "base/text.hpp"

namespace cas::base {
namespace {

/// An included file.
struct SdfFile {
  XmlElement root;  ///< <sdf>
  std::filesystem::path path;
};

namespace fs = std::filesystem;

/// The SDF of a model's folder: the last that its model.config names, else model.sdf.
fs::path sdf_in(const fs::path& folder) {
  const fs::path config = folder / "model.config";
  std::error_code error;
  if (!fs::exists(config, error)) return folder / "model.sdf";
  const XmlElement root =
      parse_xml(read_foreign_file(config, "model.config", kMaxModelBytes), config.string());
  std::string_view name = "model.sdf";
  for (const XmlElement& child : root.children) {
    if (child.name == "sdf") name = without_space(child.text);
  }
  return folder / name;
}

[[noreturn]] void fail_missing_file(const XmlElement& include, const fs::path& path) {
  std::error_code error;
  const fs::path form = path.string() + ".jinja";
  include.fail("the included file " + path.string() + " is not there" +
               (fs::exists(form, error)
                    ? "; " + form.string() + " is a template, which a build fills in"
                    : ""));
}

[[noreturn]] void fail_missing(const XmlElement& include, const std::string& uri,
                               const fs::path& file) {
  include.fail("the included model " + uri + " is nowhere to be found; looked for it at " +
               searched_places(uri, file.parent_path(), {}) +
               ". Name its folder in GZ_SIM_RESOURCE_PATH, or leave it out by `parts: {" +
               (include.child("name") != nullptr ? std::string(include.child_text("name"))
                                                 : fs::path(uri).filename().string()) +
               ": left_out}` in the vehicle file");
}

/// Reads the file that an <include> means: the SDF itself, or a folder with its model.config.
/// @param file  that has the <include>
/// @throws ConfigError naming the <include>, and the places searched where it is missing
SdfFile read_sdf_include(const XmlElement& include, const fs::path& file) {
  const std::string uri(include.child_text("uri"));
  if (uri.empty()) include.fail("<include> has no <uri>");
  const auto found = find_model_file(uri, file.parent_path(), {});
  if (!found) fail_missing(include, uri, file);
  std::error_code error;
  const fs::path path = fs::is_directory(*found, error) ? sdf_in(*found) : *found;
  if (!fs::exists(path, error)) fail_missing_file(include, path);
  const std::string text = read_foreign_file(path, "included model", kMaxModelBytes);
  if (const auto sentence = template_language(text)) {
    include.fail(path.string() + ", which is included, is no SDF: " + *sentence);
  }
  SdfFile result{parse_xml(text, path.string()), path};
  if (result.root.name != "sdf") {
    result.root.fail("is included as a model, but its outermost element is <" + result.root.name +
                     ">, not <sdf>");
  }
  return result;
}

constexpr double kEndless_rad = 1000;  // between a joint's limits
constexpr double kStill = 1e-9;        // between the limits of a joint that does not move
constexpr int kDeepestInclude = 10;
constexpr std::size_t kMostIncludes = 100;

Eigen::Vector3d vector(const XmlElement& element) {
  const std::vector<double> v = element.numbers(3);
  return {v[0], v[1], v[2]};
}

const XmlElement& model_in(const XmlElement& sdf) {
  const XmlElement* const model = sdf.child("model");
  if (model != nullptr) return *model;
  const XmlElement* const world = sdf.child("world");
  const XmlElement* const inside = world != nullptr ? world->child("model") : nullptr;
  sdf.fail("has no <model>; a world is no vehicle" +
           (inside == nullptr
                ? std::string()
                : ": write its <model name='" + std::string(inside->attribute("name")) +
                      "'> to a file of its own"));
}

/// A bound of a joint, from its <limit>; it may be infinite.
double limit_of(const XmlElement& limit) {
  const std::string word = lower(without_space(limit.text));
  if (word == "inf" || word == "+inf" || word == "infinity") return HUGE_VAL;
  if (word == "-inf" || word == "-infinity") return -HUGE_VAL;
  return limit.numbers(1)[0];
}

/// The moments of a link, by SDF's defaults where the file has none.
Eigen::Matrix3d inertia_of(const XmlElement& inertia, const std::string& link,
                           ModelBuilder& builder) {
  return inertia_tensor([&](std::string_view key) {
    if (const XmlElement* const entry = inertia.child(key)) return entry->numbers(1)[0];
    if (key[1] != key[2]) return 0.0;
    builder.warn(inertia, "link '" + link + "': <inertia> has no <" + std::string(key) +
                              ">: 1 kg m^2, as SDF has it");
    return 1.0;
  });
}

/// Mass and inertia of a link. @param X_LM  of the model in the link
Inertial inertial_of(const XmlElement& link, const SdfScope& scope, const Eigen::Isometry3d& X_LM,
                     ModelBuilder& builder) {
  const XmlElement* const element = link.child("inertial");
  const XmlElement* const mass = element != nullptr ? element->child("mass") : nullptr;
  const XmlElement* const inertia = element != nullptr ? element->child("inertia") : nullptr;
  const std::string name(link.attribute("name"));
  if (mass == nullptr || inertia == nullptr) {
    (element != nullptr ? *element : link)
        .fail("link '" + name +
              "' has no <inertial> with <mass> and <inertia>; SDF would have it weigh 1 kg");
  }
  Inertial result{.mass_kg = mass->numbers(1)[0],
                  .X = X_LM * scope.pose(*element, name),
                  .inertia_kg_m2 = inertia_of(*inertia, name, builder),
                  .element = element};
  if (result.mass_kg == 0 && !result.inertia_kg_m2.isZero(0)) {
    mass->fail("link '" + name + "' has an <inertia>, and a <mass> of 0");
  }
  return result;
}

/// @throws ConfigError for a type that SDF does not have
std::string_view type_of(const XmlElement& joint) {
  constexpr std::array<std::string_view, 9> kTypes{"fixed", "continuous", "revolute",
                                                   "ball",  "revolute2",  "prismatic",
                                                   "screw", "universal",  "gearbox"};
  const std::string_view type = joint.attribute("type");
  if (std::ranges::find(kTypes, type) != kTypes.end()) return type;
  joint.fail("joint '" + std::string(joint.attribute("name")) + "' has the type '" +
             std::string(type) + "', which SDF does not have");
}

class Sdf {
 public:
  Sdf(const XmlElement& sdf, const std::filesystem::path& file, const ModelParts& parts)
      : builder_(file, parts), root_(model_in(sdf), sdf.attribute("version"), file) {
    warn_of_others(sdf);
    add_parts(root_, sdf.attribute("version"), 0);
    place(root_, Eigen::Isometry3d::Identity());
  }

  ModelBody run() {
    take_links(root_);
    warn_of_loose(joints_.loose(links_));
    ModelBody body = builder_.finish(std::string(root_.model().attribute("name")));
    if (body.links.empty()) root_.model().fail("has no <link>");
    return body;
  }

 private:
  /// A vehicle is one model.
  void warn_of_others(const XmlElement& sdf) {
    const XmlElement* const model = sdf.child("model");
    for (const XmlElement& child : sdf.children) {
      if (&child == model || (child.name != "model" && child.name != "world")) continue;
      builder_.warn(child, "<" + child.name + " name='" + std::string(child.attribute("name")) +
                               "'> is left out: the vehicle is the first <model> of a file");
    }
  }

  /// @param loose  links that no joint holds
  void warn_of_loose(const std::vector<std::string>& loose) {
    if (loose.empty()) return;
    const std::string more =
        loose.size() > 1 ? " nor " + std::to_string(loose.size() - 1) + " more" : "";
    builder_.warn(root_.model(), "no joint holds link '" + loose.front() + "'" + more + " to '" +
                                     links_.front() + "': in Gazebo they fall off; taken as fixed");
  }

  /// The models in a model, and those in them.
  void add_parts(SdfScope& scope, std::string_view version, int depth) {
    for (const XmlElement& child : scope.model().children) {
      if (child.name == "include") {
        if (depth >= kDeepestInclude || files_.size() >= kMostIncludes) {
          child.fail("models include each other without end");
        }
        include(child, scope, depth);
      } else if (child.name == "model") {
        if (builder_.leaves_out(child.attribute("name"))) {
          scope.leave_out(child.attribute("name"), false);
          continue;
        }
        auto part = std::make_unique<SdfScope>(child, version, scope.file(), scope, nullptr);
        add(std::move(part), scope, version, depth, {child.attribute("name")});
      }
    }
  }

  void include(const XmlElement& element, SdfScope& scope, int depth) {
    const std::string in_uri = std::filesystem::path(element.child_text("uri")).filename().string();
    // Whichever name the vehicle file uses; the file itself may be missing.
    const bool by_uri = builder_.leaves_out(in_uri);
    const bool merged = is_true(element.attribute("merge"));
    if (builder_.leaves_out(element.child_text("name")) || by_uri) {
      const std::string_view name = element.child_text("name");
      // Without a <name> its own counts, which nobody has read.
      return scope.leave_out(name, merged || name.empty());
    }
    const SdfFile& file = files_.emplace_back(read_sdf_include(element, scope.file()));
    const XmlElement& model = model_in(file.root);
    if (const auto name = sdf_part_name(model, &element); builder_.leaves_out(name)) {
      return scope.leave_out(name, merged);
    }
    warn_of_others(file.root);
    const std::string_view version = file.root.attribute("version");
    auto part = std::make_unique<SdfScope>(model, version, file.path, scope, &element);
    add(std::move(part), scope, version, depth, {sdf_part_name(model, &element), in_uri});
  }

  /// @param names  by which the vehicle file may fix the part
  void add(std::unique_ptr<SdfScope> part, SdfScope& scope, std::string_view version, int depth,
           std::initializer_list<std::string_view> names) {
    bool fixed = fixed_.contains(&scope);
    for (const std::string_view name : names) fixed |= builder_.fixes(name);
    if (fixed) fixed_.insert(part.get());
    add_parts(*part, version, depth + 1);
    scope.add(std::move(part));
  }

  /// Frames and joints of a model and of those in it.
  void place(const SdfScope& scope, const Eigen::Isometry3d& X_RM) {
    frames_[&scope] = X_RM;
    check_sdf_elements(scope.model(), builder_);
    joints_.add(scope, builder_);
    for (const XmlElement& frame : scope.model().children) {
      const std::string_view name = frame.attribute("name");
      if (frame.name == "frame" && scope.link_of(name, frame)) scope.frame(name, frame);
    }
    for (const auto& part : scope.parts()) place(*part, X_RM * scope.placed(*part));
  }

  void take_links(const SdfScope& scope) {
    for (const XmlElement& child : scope.model().children) {
      if (child.name == "link") add_link(child, scope, frames_.at(&scope));
    }
    take_motors(scope.model(), scope);
    if (scope.include() != nullptr) take_motors(*scope.include(), scope);
    for (const auto& part : scope.parts()) take_links(*part);
  }

  void take_motors(const XmlElement& element, const SdfScope& scope) {
    for (const XmlElement& child : element.children) {
      if (child.name != "plugin") continue;
      if (auto motor = read_model_motor(child, scope.prefix())) builder_.add(*std::move(motor));
    }
  }

  void add_link(const XmlElement& link, const SdfScope& scope, const Eigen::Isometry3d& X_RM) {
    const std::string_view own_name = link.attribute("name");
    const std::string name = scope.prefix() + std::string(own_name);
    const Eigen::Isometry3d X_ML = scope.pose(link, SdfScope::kModelFrame);
    const Eigen::Isometry3d X_RL = X_RM * X_ML;
    LinkJoint joint;
    Eigen::Vector3d position_R_m = X_RL.translation();
    if (const SdfJoints::Joint* const carrier = joints_.carrier_of(name)) {
      joint = joint_of(*carrier, position_R_m);
    }
    if (fixed_.contains(&scope)) {
      joint.moves = false;
      joint.axis_R.reset();
    }
    const auto turns = builder_.add(link, name, X_RL, joint, position_R_m,
                                    inertial_of(link, scope, X_ML.inverse(), builder_));
    if (!turns) return;
    links_.push_back(name);
    for (const XmlElement& part : link.children) {
      if (part.name != "collision" && part.name != "visual") continue;
      builder_.add_shape(part, FormValues::kElements, scope.file(), *turns,
                         [&] { return X_RM * scope.pose(part, own_name); });
    }
  }

  LinkJoint joint_of(const SdfJoints::Joint& joint, Eigen::Vector3d& position_R_m) const {
    const XmlElement& element = *joint.element;
    const Eigen::Isometry3d& X_RM = frames_.at(joint.scope);
    const Eigen::Isometry3d X_MJ = joint.scope->pose(element, element.child_text("child"));
    position_R_m = X_RM * X_MJ.translation();
    LinkJoint result{.element = &element,
                     .name = joint.scope->prefix() + std::string(element.attribute("name")),
                     .moves = range(element) > kStill};
    if (range(element) > kEndless_rad) {
      result.axis_R = (X_RM.linear() * axis_M(joint, X_MJ)).stableNormalized();
    }
    return result;
  }

  /// From limit to limit: infinite for one that turns, 1 for one that moves in another way.
  static double range(const XmlElement& joint) {
    const std::string_view type = type_of(joint);
    if (type == "continuous") return HUGE_VAL;
    if (type == "fixed") return 0;
    const XmlElement* const axis = joint.child("axis");
    const XmlElement* const limit = axis != nullptr ? axis->child("limit") : nullptr;
    const XmlElement* const lower = limit != nullptr ? limit->child("lower") : nullptr;
    const XmlElement* const upper = limit != nullptr ? limit->child("upper") : nullptr;
    const bool limited = lower != nullptr && upper != nullptr;
    const double between = limited ? limit_of(*upper) - limit_of(*lower) : HUGE_VAL;
    return type == "revolute" ? between : std::min(between, 1.0);
  }

  static Eigen::Vector3d axis_M(const SdfJoints::Joint& joint, const Eigen::Isometry3d& X_MJ) {
    const XmlElement& element = *joint.element;
    const XmlElement* const axis = element.child("axis");
    const XmlElement* const xyz = axis != nullptr ? axis->child("xyz") : nullptr;
    const Eigen::Vector3d v = xyz != nullptr ? vector(*xyz) : Eigen::Vector3d::UnitZ();
    if (v.norm() < 1e-9) xyz->fail("<xyz> of an axis is zero");
    // Up to SDF 1.4 axes are in the model's frame, up to 1.6 where the file says so.
    const bool in_model = axis != nullptr && is_true(axis->child_text("use_parent_model_frame"));
    if (joint.scope->axes_in_model() || in_model) return v;
    const std::string_view in = xyz != nullptr ? xyz->attribute("expressed_in") : "";
    return (in.empty() ? X_MJ : joint.scope->frame(in, element)).linear() * v;
  }

  ModelBuilder builder_;
  std::deque<SdfFile> files_;  // included; scopes point into them
  SdfScope root_;
  std::set<const SdfScope*> fixed_;  // models none of whose links is a rotor
  SdfJoints joints_;
  std::vector<std::string> links_;  // that are not left out
  std::map<const SdfScope*, Eigen::Isometry3d> frames_;
};

}  // namespace

ModelBody read_sdf_model(const XmlElement& sdf, const std::filesystem::path& file,
                         const ModelParts& parts) {
  return Sdf(sdf, file, parts).run();
}

}  // namespace cas::base
