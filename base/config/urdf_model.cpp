// SPDX-License-Identifier: BSD-3-Clause
#include "base/config/urdf_model.hpp"

#include <algorithm>
#include <array>
#include <functional>

#include "base/config/model_builder.hpp"
#include "base/config/model_motors.hpp"
#include "base/config/unread_elements.hpp"

namespace cas::base {
namespace {

constexpr std::array<std::string_view, 6> kJointTypes{"revolute", "continuous", "prismatic",
                                                      "fixed",    "floating",   "planar"};

constexpr std::array<KnownElement, 15> kUrdfElements{
    {{"link", "inertial",
      "collision visual contact sensor gazebo material self_collision_checking audio_source",
      "name type"},
     {"inertial", "origin mass inertia", "", "name"},
     {"collision", "origin geometry material verbose contact_coefficients", "",
      "name group concave"},
     {"visual", "origin geometry material", "", "name"},
     {"joint",
      "origin parent child axis limit dynamics mimic calibration safety_controller "
      "joint_properties",
      "", "name type"},
     {"origin", "", "", "xyz rpy"},
     {"axis", "", "", "xyz rpy"},
     {"parent", "", "", "link"},
     {"child", "", "", "link"},
     {"mass", "", "", "value"},
     {"inertia", "", "", "ixx ixy ixz iyy iyz izz"},
     {"box", "", "", "size"},
     {"sphere", "", "", "radius"},
     {"cylinder", "", "", "radius length"},
     {"mesh", "", "", "filename scale"}}};

/// Elements of a <robot>; those but for links and joints say nothing about its body.
constexpr std::array<std::string_view, 12> kOfRobot{
    "link",       "joint",  "gazebo", "material", "transmission", "sensor",
    "properties", "mujoco", "plugin", "author",   "version",      "license"};

std::string in_quotes(std::string_view name) { return "'" + std::string(name) + "'"; }

std::string_view need_attribute(const XmlElement& element, std::string_view key) {
  const std::string_view value = element.attribute(key);
  if (value.empty()) element.fail("<" + element.name + "> has no attribute " + in_quotes(key));
  return value;
}

double number(const XmlElement& element, std::string_view key) {
  need_attribute(element, key);
  return element.numbers(key, 1)[0];
}

Eigen::Vector3d vector(const XmlElement& element, std::string_view key,
                       const Eigen::Vector3d& fallback) {
  if (!element.attributes.contains(key)) return fallback;
  const std::vector<double> v = element.numbers(key, 3);
  return {v[0], v[1], v[2]};
}

/// The <origin> of an element in its parent; the parent's own where there is none.
Eigen::Isometry3d origin_of(const XmlElement& element) {
  Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
  const XmlElement* const origin = element.child("origin");
  if (origin == nullptr) return X;
  const Eigen::Vector3d rpy = vector(*origin, "rpy", Eigen::Vector3d::Zero());
  X.translation() = vector(*origin, "xyz", Eigen::Vector3d::Zero());
  X.linear() = rotation_rpy(rpy.x(), rpy.y(), rpy.z());
  return X;
}

std::optional<Inertial> inertial_of(const XmlElement& link) {
  const XmlElement* const element = link.child("inertial");
  if (element == nullptr) return std::nullopt;
  Inertial result{.mass_kg = number(element->need("mass"), "value"),
                  .X = origin_of(*element),
                  .element = element};
  const XmlElement& inertia = element->need("inertia");
  result.inertia_kg_m2 = inertia_tensor([&](const char* key) { return number(inertia, key); });
  return result;
}

struct Joint {
  const XmlElement* element = nullptr;
  std::string_view type;
  std::string_view parent;
  std::string_view child;
};

class Urdf {
 public:
  Urdf(const XmlElement& robot, const std::filesystem::path& file, const ModelParts& parts)
      : robot_(robot), file_(file), builder_(file, parts) {}

  ModelBody run() {
    collect_links();
    collect_joints();
    walk();
    take_motors();
    warn_of_others();
    return builder_.finish(std::string(robot_.attribute("name")));
  }

 private:
  void collect_links() {
    for (const XmlElement& link : robot_.children) {
      if (link.name != "link") continue;
      const std::string_view name = need_attribute(link, "name");
      if (!links_.emplace(name, &link).second) {
        link.fail("a second <link> is called " + in_quotes(name));
      }
    }
    if (links_.empty()) robot_.fail("<robot> has no <link>");
  }

  void collect_joints() {
    for (const XmlElement& element : robot_.children) {
      if (element.name != "joint") continue;
      const std::string_view name = need_attribute(element, "name");
      if (!joints_.insert(name).second) {
        element.fail("a second <joint> is called " + in_quotes(name));
      }
      const Joint joint{.element = &element,
                        .type = need_attribute(element, "type"),
                        .parent = link_named_in(element.need("parent")),
                        .child = link_named_in(element.need("child"))};
      if (std::ranges::find(kJointTypes, joint.type) == kJointTypes.end()) {
        element.fail("joint " + in_quotes(name) + " has the unknown type " + in_quotes(joint.type));
      }
      warn_of_unread(element, kUrdfElements, builder_, look_at_);
      if (!carried_.insert(joint.child).second) {
        element.fail("link " + in_quotes(joint.child) + " is the child of two joints");
      }
      outwards_[joint.parent].push_back(joint);
    }
  }

  std::string_view link_named_in(const XmlElement& end) const {
    const std::string_view name = need_attribute(end, "link");
    if (!links_.contains(name)) {
      end.fail("<" + end.name + "> of a joint names the link " + in_quotes(name) +
               ", which is not there");
    }
    return name;
  }

  std::string_view root() const {
    const XmlElement* first = nullptr;
    for (const XmlElement& link : robot_.children) {
      if (link.name != "link" || carried_.contains(link.attribute("name"))) continue;
      if (first != nullptr) {
        link.fail("link " + in_quotes(link.attribute("name")) +
                  " hangs on no joint, and neither does " + in_quotes(first->attribute("name")) +
                  ": a vehicle is one tree of links");
      }
      first = &link;
    }
    if (first == nullptr) robot_.fail("the joints go round in a circle: no link is the root");
    return first->attribute("name");
  }

  /// From the root outwards, without recursion: a file may hang each link on the one before.
  void walk() {
    struct Visit {
      std::string_view link;
      Eigen::Isometry3d X_RL;
      const Joint* joint;
    };
    std::vector<Visit> open{{root(), Eigen::Isometry3d::Identity(), nullptr}};
    std::size_t visited = 0;
    while (!open.empty()) {
      const Visit at = open.back();
      open.pop_back();
      ++visited;
      add(*links_.at(at.link), at.X_RL, at.joint);
      const auto next = outwards_.find(at.link);
      if (next == outwards_.end()) continue;
      for (std::size_t i = next->second.size(); i-- > 0;) {
        const Joint& joint = next->second[i];
        open.push_back({joint.child, at.X_RL * origin_of(*joint.element), &joint});
      }
    }
    if (visited != links_.size()) robot_.fail("some of the joints go round in a circle");
  }

  void add(const XmlElement& link, const Eigen::Isometry3d& X_RL, const Joint* joint) {
    const auto turns = builder_.add(link, std::string(link.attribute("name")), X_RL,
                                    joint_of(joint, X_RL), X_RL.translation(), inertial_of(link));
    if (!turns) return;
    warn_of_unread(link, kUrdfElements, builder_, look_at_);
    for (const XmlElement& part : link.children) {
      if (part.name != "collision" && part.name != "visual") continue;
      builder_.add_shape(part, FormValues::kAttributes, file_, *turns,
                         [&] { return X_RL * origin_of(part); });
    }
  }

  /// A template's macro with another prefix than xacro's leaves links out.
  void warn_of_others() {
    for (const XmlElement& part : robot_.children) {
      if (std::ranges::find(kOfRobot, part.name) != kOfRobot.end()) continue;
      if (part.name.starts_with("drake:")) continue;
      builder_.warn(part, "<" + part.name + "> in <robot> is left out: no such element");
    }
  }

  static LinkJoint joint_of(const Joint* joint, const Eigen::Isometry3d& X_RL) {
    if (joint == nullptr) return {};
    LinkJoint result{.element = joint->element,
                     .name = std::string(joint->element->attribute("name")),
                     .moves = joint->type != "fixed"};
    if (joint->type != "continuous") return result;
    const XmlElement* const axis = joint->element->child("axis");
    const Eigen::Vector3d v = axis == nullptr ? Eigen::Vector3d(Eigen::Vector3d::UnitX())
                                              : vector(*axis, "xyz", Eigen::Vector3d::UnitX());
    if (v.norm() < 1e-9) axis->fail("joint " + in_quotes(result.name) + ": <axis> is zero");
    result.axis_R = (X_RL.linear() * v).stableNormalized();
    return result;
  }

  void take_motors() {
    for (const XmlElement& gazebo : robot_.children) {
      if (gazebo.name != "gazebo") continue;
      for (const XmlElement& plugin : gazebo.children) {
        if (plugin.name != "plugin") continue;
        if (auto motor = read_model_motor(plugin, "")) builder_.add(*std::move(motor));
      }
    }
  }

  const XmlElement& robot_;
  const std::filesystem::path& file_;
  ModelBuilder builder_;
  const std::function<bool(const XmlElement&)> look_at_ = [this](const XmlElement& element) {
    if (element.name == "origin") builder_.warn_of_degrees(element, element.attribute("rpy"), 0);
    return true;
  };
  std::map<std::string_view, const XmlElement*> links_;
  std::map<std::string_view, std::vector<Joint>> outwards_;  // by their parents
  std::set<std::string_view> carried_;                       // children of joints
  std::set<std::string_view> joints_;                        // by name
};

}  // namespace

ModelBody read_urdf_model(const XmlElement& robot, const std::filesystem::path& file,
                          const ModelParts& parts) {
  return Urdf(robot, file, parts).run();
}

}  // namespace cas::base
