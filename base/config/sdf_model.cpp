// SPDX-License-Identifier: BSD-3-Clause
#include "base/config/sdf_model.hpp"

#include <algorithm>
#include <cmath>
#include <deque>

#include "base/config/model_builder.hpp"
#include "base/config/model_motors.hpp"
#include "base/config/sdf_include.hpp"
#include "base/config/sdf_scope.hpp"
#include "base/error.hpp"

namespace cas::base {
namespace {

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
  if (model == nullptr) sdf.fail("has no <model>; a world is no vehicle");
  return *model;
}

/// Mass and inertia of a link. @param X_LM  of the model in the link
Inertial inertial_of(const XmlElement& link, const SdfScope& scope, const Eigen::Isometry3d& X_LM) {
  const XmlElement* const element = link.child("inertial");
  const XmlElement* const mass = element != nullptr ? element->child("mass") : nullptr;
  const XmlElement* const inertia = element != nullptr ? element->child("inertia") : nullptr;
  const std::string name(link.attribute("name"));
  if (mass == nullptr || inertia == nullptr) {
    (element != nullptr ? *element : link)
        .fail("link '" + name +
              "' has no <inertial> with <mass> and <inertia>; SDF would have it weigh 1 kg");
  }
  Inertial result{
      .mass_kg = mass->numbers(1)[0], .X = X_LM * scope.pose(*element, name), .element = element};
  result.inertia_kg_m2 = inertia_tensor([&](std::string_view key) {
    const XmlElement* const entry = inertia->child(key);
    return entry != nullptr ? entry->numbers(1)[0] : key[1] == key[2] ? 1.0 : 0.0;
  });
  return result;
}

class Sdf {
 public:
  Sdf(const XmlElement& sdf, const std::filesystem::path& file, const ModelParts& parts)
      : builder_(file, parts), root_(model_in(sdf), sdf.attribute("version"), file) {
    add_parts(root_, sdf.attribute("version"), 0);
    place(root_, Eigen::Isometry3d::Identity());
  }

  ModelBody run() {
    take_links(root_);
    ModelBody body = builder_.finish(std::string(root_.model().attribute("name")));
    if (body.links.empty()) root_.model().fail("has no <link>");
    return body;
  }

 private:
  /// The models in a model, and those in them.
  void add_parts(SdfScope& scope, std::string_view version, int depth) {
    for (const XmlElement& child : scope.model().children) {
      if (child.name == "include") {
        if (depth >= kDeepestInclude || files_.size() >= kMostIncludes) {
          child.fail("models include each other without end");
        }
        include(child, scope, depth);
      } else if (child.name == "model") {
        if (builder_.leaves_out(child.attribute("name"))) continue;
        auto part = std::make_unique<SdfScope>(child, version, scope.file(), scope, nullptr);
        add_parts(*part, version, depth + 1);
        scope.add(std::move(part));
      }
    }
  }

  void include(const XmlElement& element, SdfScope& scope, int depth) {
    const std::string uri(element.child_text("uri"));
    // Whichever name the vehicle file uses; the file itself may be missing.
    const bool by_uri = builder_.leaves_out(std::filesystem::path(uri).filename().string());
    if (builder_.leaves_out(element.child_text("name")) || by_uri) return;
    const SdfFile& file = files_.emplace_back(read_sdf_include(element, scope.file()));
    const XmlElement& model = model_in(file.root);
    if (builder_.leaves_out(sdf_part_name(model, &element))) return;
    const std::string_view version = file.root.attribute("version");
    auto part = std::make_unique<SdfScope>(model, version, file.path, scope, &element);
    add_parts(*part, version, depth + 1);
    scope.add(std::move(part));
  }

  struct Joint {
    const XmlElement* element;
    const SdfScope* scope;
  };

  /// Frames and joints of a model and of those in it.
  void place(const SdfScope& scope, const Eigen::Isometry3d& X_RM) {
    frames_[&scope] = X_RM;
    for (const XmlElement& joint : scope.model().children) {
      if (joint.name != "joint") continue;
      joints_.emplace(scope.prefix() + std::string(joint.child_text("child")),
                      Joint{&joint, &scope});
    }
    for (const auto& part : scope.parts()) place(*part, X_RM * scope.placed(*part));
  }

  void take_links(const SdfScope& scope) {
    for (const XmlElement& child : scope.model().children) {
      if (child.name == "link") add_link(child, scope, frames_.at(&scope));
      if (child.name != "plugin") continue;
      if (auto motor = read_model_motor(child, scope.prefix())) builder_.add(*std::move(motor));
    }
    for (const auto& part : scope.parts()) take_links(*part);
  }

  void add_link(const XmlElement& link, const SdfScope& scope, const Eigen::Isometry3d& X_RM) {
    const std::string_view own_name = link.attribute("name");
    const std::string name = scope.prefix() + std::string(own_name);
    const Eigen::Isometry3d X_ML = scope.pose(link, SdfScope::kModelFrame);
    const Eigen::Isometry3d X_RL = X_RM * X_ML;
    LinkJoint joint;
    Eigen::Vector3d position_R_m = X_RL.translation();
    if (const auto found = joints_.find(name); found != joints_.end()) {
      joint = joint_of(found->second, position_R_m);
    }
    const auto turns = builder_.add(link, name, X_RL, joint, position_R_m,
                                    inertial_of(link, scope, X_ML.inverse()));
    if (!turns) return;
    for (const XmlElement& part : link.children) {
      if (part.name != "collision" && part.name != "visual") continue;
      builder_.add_shape(part, FormValues::kElements, scope.file(), *turns,
                         [&] { return X_RM * scope.pose(part, own_name); });
    }
  }

  LinkJoint joint_of(const Joint& joint, Eigen::Vector3d& position_R_m) const {
    const XmlElement& element = *joint.element;
    const std::string_view name = element.attribute("name");
    const Eigen::Isometry3d& X_RM = frames_.at(joint.scope);
    position_R_m = X_RM * joint.scope->frame(name, element).translation();
    LinkJoint result{.element = &element,
                     .name = joint.scope->prefix() + std::string(name),
                     .moves = range(element) > kStill};
    if (range(element) > kEndless_rad) {
      result.axis_R = (X_RM.linear() * axis_M(joint)).stableNormalized();
    }
    return result;
  }

  /// From limit to limit: infinite for one that turns, 1 for one that moves in another way.
  static double range(const XmlElement& joint) {
    const std::string_view type = joint.attribute("type");
    if (type == "continuous") return HUGE_VAL;
    if (type == "fixed") return 0;
    const XmlElement* const axis = joint.child("axis");
    const XmlElement* const limit = axis != nullptr ? axis->child("limit") : nullptr;
    const XmlElement* const lower = limit != nullptr ? limit->child("lower") : nullptr;
    const XmlElement* const upper = limit != nullptr ? limit->child("upper") : nullptr;
    const bool limited = lower != nullptr && upper != nullptr;
    const double between = limited ? upper->numbers(1)[0] - lower->numbers(1)[0] : HUGE_VAL;
    return type == "revolute" ? between : std::min(between, 1.0);
  }

  static Eigen::Vector3d axis_M(const Joint& joint) {
    const XmlElement& element = *joint.element;
    const XmlElement* const axis = element.child("axis");
    const XmlElement* const xyz = axis != nullptr ? axis->child("xyz") : nullptr;
    const Eigen::Vector3d v = xyz != nullptr ? vector(*xyz) : Eigen::Vector3d::UnitZ();
    if (v.norm() < 1e-9) xyz->fail("<xyz> of an axis is zero");
    std::string_view in = element.attribute("name");
    if (xyz != nullptr && !xyz->attribute("expressed_in").empty()) {
      in = xyz->attribute("expressed_in");
    }
    // Up to SDF 1.4 axes are in the model's frame, up to 1.6 where the file says so.
    const std::string_view flag = axis != nullptr ? axis->child_text("use_parent_model_frame") : "";
    if (joint.scope->axes_in_model() || flag == "1" || flag == "true") in = SdfScope::kModelFrame;
    return joint.scope->frame(in, element).linear() * v;
  }

  ModelBuilder builder_;
  std::deque<SdfFile> files_;  // included; scopes point into them
  SdfScope root_;
  std::map<std::string, Joint, std::less<>> joints_;  // by the link that is the child
  std::map<const SdfScope*, Eigen::Isometry3d> frames_;
};

}  // namespace

ModelBody read_sdf_model(const XmlElement& sdf, const std::filesystem::path& file,
                         const ModelParts& parts) {
  return Sdf(sdf, file, parts).run();
}

}  // namespace cas::base
