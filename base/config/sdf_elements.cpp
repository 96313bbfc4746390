// SPDX-License-Identifier: BSD-3-Clause
#include "base/config/sdf_elements.hpp"

#include <algorithm>
#include <array>
#include <string_view>

#include "base/config/sdf_scope.hpp"
#include "base/config/unread_elements.hpp"
#include "base/text.hpp"

namespace cas::base {
namespace {

/// SDF 1.2 to 1.12, as far as it describes a body.
constexpr std::array<KnownElement, 15> kSdfElements{{
    {"model", "static self_collide allow_auto_disable enable_wind pose",
     "frame link joint plugin gripper include model", "name canonical_link placement_frame"},
    {"include", "uri name static pose placement_frame", "plugin", "merge"},
    {"link", "pose gravity enable_wind self_collide kinematic must_be_base_link inertial",
     "collision visual sensor projector audio_sink audio_source battery light "
     "particle_emitter velocity_decay frame plugin",
     "name"},
    {"inertial", "mass pose inertia density fluid_added_mass", "frame", "auto"},
    {"inertia", "ixx ixy ixz iyy iyz izz", "", ""},
    {"collision", "pose geometry surface laser_retro max_contacts density auto_inertia_params",
     "frame", "name"},
    {"box", "size", "", ""},
    {"sphere", "radius", "", ""},
    {"cylinder", "radius length", "", ""},
    {"mesh", "uri scale submesh convex_decomposition", "", "optimization"},
    {"joint",
     "parent child pose axis axis2 physics gearbox_ratio gearbox_reference_body thread_pitch "
     "screw_thread_pitch",
     "frame sensor", "name type"},
    {"axis", "xyz initial_position use_parent_model_frame dynamics limit mimic", "", ""},
    {"frame", "pose", "", "name attached_to"},
    {"pose", "", "", "relative_to frame degrees rotation_format"},
    {"xyz", "", "", "expressed_in"},
}};

/// Whether a plugin of Gazebo pushes or turns a body, apart from its rotors.
bool acts_on_body(const XmlElement& plugin) {
  constexpr std::array<std::string_view, 8> kNames{"liftdrag",  "lift-drag",   "lift_drag",
                                                   "buoyan",    "hydrodyna",   "thruster",
                                                   "parachute", "wind_effects"};
  const std::string text = lower(std::string(plugin.attribute("filename")) + " " +
                                 std::string(plugin.attribute("name")));
  return std::ranges::any_of(
      kNames, [&text](std::string_view name) { return text.find(name) != text.npos; });
}

class Check {
 public:
  explicit Check(ModelBuilder& builder) : builder_(builder) {}

  void run(const XmlElement& model) {
    warn_of_unread(model, kSdfElements, builder_, [this](const XmlElement& element) {
      look_at(element);
      return element.name != "model";
    });
  }

 private:
  void look_at(const XmlElement& element) {
    if (element.name == "experimental:params") {
      element.fail("parameters of an <include> are not read; write them into the included model");
    }
    if (element.name == "pose" && !is_true(element.attribute("degrees")) &&
        element.attribute("rotation_format") != "quat_xyzw") {
      builder_.warn_of_degrees(element, element.text, 3);
    }
    const std::string who = tag_of(element);
    if (element.name == "plugin" && acts_on_body(element)) {
      builder_.warn(element, who + " acts on the model in Gazebo, and is left out here");
    }
    if (element.name == "static" && is_true(element.text)) {
      builder_.warn(element, "<static> holds the model in Gazebo: left out, a vehicle flies");
    }
    if (element.name == "fluid_added_mass") {
      builder_.warn(element, "<fluid_added_mass> is left out");
    }
    const std::string_view gravity = element.name == "link" ? element.child_text("gravity") : "";
    if (gravity == "0" || gravity == "false") {
      builder_.warn(element, who + " has no <gravity> in Gazebo; it weighs here");
    }
    if (element.name == "surface" && !surface_told_ && acts_on_contact(element)) {
      surface_told_ = true;
      builder_.warn(element,
                    "a <surface> of a vehicle is left out, here and elsewhere in this file: its "
                    "friction is 1, and its stiffness the default");
    }
  }

  /// Whether a <surface> says more than defaults.
  static bool acts_on_contact(const XmlElement& element) {
    constexpr std::array<std::string_view, 6> kValues{
        "mu", "kp", "kd", "soft_contact", "collide_without_contact", "collide_bitmask"};
    const auto is_value = std::ranges::find(kValues, element.name) != kValues.end();
    return is_value || std::ranges::any_of(element.children, acts_on_contact);
  }

  ModelBuilder& builder_;
  bool surface_told_ = false;
};

}  // namespace

void check_sdf_elements(const XmlElement& model, ModelBuilder& builder) {
  Check(builder).run(model);
}

}  // namespace cas::base
