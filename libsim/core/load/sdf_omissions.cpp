// SPDX-License-Identifier: BSD-3-Clause
#include "libsim/core/load/sdf_omissions.hpp"

#include <fmt/format.h>
#include <algorithm>
#include <array>
#include <cmath>
#include <initializer_list>
#include <map>
#include <set>
#include <string_view>

#include "libsim/core/load/sdf_numbers.hpp"

namespace cas::sim {

namespace {

constexpr std::size_t kNamed = 3;  // of one kind; the others are counted
constexpr unsigned kEveryBit = 0xFFFF;

/// The forms of a <geometry>, in the order in which libsdformat looks for the one that it takes.
constexpr std::array<const char*, 11> kForms{"box",   "capsule", "cylinder", "ellipsoid",
                                             "plane", "sphere",  "mesh",     "heightmap",
                                             "image", "cone",    "polyline"};

/// Elements of which a parent has one of each name.
constexpr std::array<std::string_view, 5> kNamedElements{"model", "actor", "link", "collision",
                                                         "frame"};

/// The child, or nothing; reading it never makes one up.
sdf::ElementPtr child(const sdf::ElementPtr& element, const std::string& name) {
  if (!element || !element->HasElement(name)) return nullptr;
  sdf::ElementPtr found = element->GetElement(name);
  return found->GetExplicitlySetInFile() ? found : nullptr;
}

sdf::ElementPtr descendant(sdf::ElementPtr element, std::initializer_list<const char*> names) {
  for (const char* name : names) element = child(element, name);
  return element;
}

double number(const sdf::ElementPtr& element, const std::string& name, double fallback) {
  const sdf::ElementPtr found = child(element, name);
  return found ? found->Get<double>() : fallback;
}

std::string text_of(double value) { return fmt::format("{:g}", value); }

std::string attribute(const sdf::Element& element, const std::string& key) {
  return element.HasAttribute(key) ? element.GetAttribute(key)->GetAsString() : std::string();
}

std::string name_of(const sdf::Element& element) { return attribute(element, "name"); }

/// Whether a plugin of Gazebo makes a flying vehicle of its model.
bool turns_rotors(const std::string& plugin_file) {
  constexpr std::array<std::string_view, 7> kPlugins{
      "motor_model",         "motor-model",     "MulticopterMotorModel", "multicopter-motor-model",
      "multicopter-control", "ArduPilotPlugin", "mavlink_interface"};
  const auto is_part = [&](std::string_view name) {
    return plugin_file.find(name) != std::string::npos;
  };
  return std::any_of(kPlugins.begin(), kPlugins.end(), is_part);
}

/// Collects sentences; the same place and sentence (a model that is included twice) counts once.
class Omissions {
 public:
  void note(const std::string& kind, const sdf::Element& at, const std::string& sentence) {
    const std::string line = place_of(at) + ": " + sentence;
    if (!seen_.insert(line).second) return;
    std::vector<std::string>& lines = kinds_[kind];
    if (lines.empty()) order_.push_back(kind);
    lines.push_back(line);
  }

  std::vector<std::string> sentences() const {
    std::vector<std::string> all;
    for (const std::string& kind : order_) {
      const std::vector<std::string>& lines = kinds_.at(kind);
      for (std::size_t i = 0; i < lines.size() && i < kNamed; ++i) all.push_back(lines[i]);
      if (lines.size() <= kNamed) continue;
      all.back() += fmt::format("; and {} more places like this", lines.size() - kNamed);
    }
    return all;
  }

 private:
  std::set<std::string> seen_;
  std::map<std::string, std::vector<std::string>> kinds_;
  std::vector<std::string> order_;
};

/// Goes through the elements that could move, hold or stop a vehicle.
class Walk {
 public:
  std::vector<std::string> run(const sdf::ElementPtr& world) {
    look_at_world(world);
    for (sdf::ElementPtr part = world->GetFirstElement(); part; part = part->GetNextElement()) {
      if (part->GetName() == "model") look_at_model(part, "");
      if (part->GetName() == "actor") look_at_actor(part);
    }
    look_at_elements(world);
    return omissions_.sentences();
  }

 private:
  void look_at_world(const sdf::ElementPtr& world) {
    for (const char* name : {"plugin", "road", "state", "population", "joint"}) {
      for_each(world, name, [&](const sdf::ElementPtr& part) {
        note(std::string("world ") + name, part,
             "<" + std::string(name) + named(*part) + "> is left out");
      });
    }
  }

  void look_at_model(const sdf::ElementPtr& model, const std::string& parent) {
    const std::string path = parent + name_of(*model);
    const std::string who = "model '" + path + "'";
    const auto is_static = child(model, "static");
    if (parent.empty() && !(is_static && is_static->Get<bool>())) {
      note("moves", model, who + " is not <static>; it stands still here");
    }
    if (const auto joint = child(model, "joint")) {
      note("joints", joint, who + " has joints; they are stiff here");
    }
    bool is_vehicle = false;
    for_each(model, "plugin", [&](const sdf::ElementPtr& part) {
      const std::string file = attribute(*part, "filename");
      if (!is_vehicle && turns_rotors(file)) {
        is_vehicle = true;
        note("vehicle", part,
             who + " is a vehicle (its <plugin> '" + name_of(*part) + "' is " + file +
                 "): here it stands in the world as an obstacle beside the one that flies, which "
                 "'vehicle' names; take it out");
      }
      note("model plugin", part, who + ": <plugin" + named(*part) + "> is left out");
    });
    for_each(model, "link", [&](const sdf::ElementPtr& link) { look_at_link(link, path); });
    for_each(model, "model",
             [&](const sdf::ElementPtr& inner) { look_at_model(inner, path + "::"); });
  }

  void look_at_actor(const sdf::ElementPtr& actor) {
    for_each(actor, "link",
             [&](const sdf::ElementPtr& link) { look_at_link(link, name_of(*actor)); });
  }

  /// What libsdformat copies without knowing it, and what it reads once only.
  void look_at_elements(const sdf::ElementPtr& parent) {
    std::set<std::string> met;
    for (sdf::ElementPtr part = parent->GetFirstElement(); part; part = part->GetNextElement()) {
      const std::string& name = part->GetName();
      const bool is_named = std::ranges::find(kNamedElements, name) != kNamedElements.end();
      const std::string what = "<" + name + (is_named ? named(*part) : "") + ">";
      const std::string where = " in <" + parent->GetName() + named(*parent) + ">";
      if (!part->GetExplicitlySetInFile() || has_no_effect(name)) continue;
      if (part->GetRequired().empty()) {  // every element that SDF knows has an entry there
        if (!is_read_elsewhere(parent->GetName(), name)) {
          note("unknown " + name, parent, what + where + " is left out: no such element");
        }
        continue;
      }
      const bool is_single = part->GetRequired() == "0" || part->GetRequired() == "1";
      if (!met.insert(what).second && (is_single || is_named)) {
        note("second " + name, part, "a second " + what + where + " is left out");
      }
      look_at_elements(part);
    }
  }

  /// An element of another program, or one of a younger or older SDF.
  static bool is_read_elsewhere(const std::string& parent, const std::string& name) {
    return name.find(':') != std::string::npos || (parent == "geometry" && name == "cone") ||
           (parent == "physics" && name == "magnetic_field");
  }

  void look_at_link(const sdf::ElementPtr& link, const std::string& model) {
    for_each(link, "sensor", [&](const sdf::ElementPtr& sensor) {
      note("sensor", sensor,
           "model '" + model + "': <sensor" + named(*sensor) +
               "> is left out: sensors are plugins of a vehicle");
    });
    for_each(link, "collision", [&](const sdf::ElementPtr& collision) {
      const std::string who = "collision '" + model + "/" + name_of(*collision) + "'";
      const auto surface = child(collision, "surface");
      look_at_friction(child(surface, "friction"), who);
      look_at_contact(surface, who);
      look_at_geometry(collision, who);
    });
  }

  void look_at_friction(const sdf::ElementPtr& friction, const std::string& who) {
    const auto ode = child(friction, "ode");
    const double mu = number(ode, "mu", 1);
    const auto mu2 = child(ode, "mu2");
    if (mu2 && mu2->Get<double>() != mu) {
      note("mu2", mu2,
           who + ": <mu2> " + text_of(mu2->Get<double>()) + " is left out: <mu> " + text_of(mu) +
               " holds in every direction");
      if (const auto along = child(ode, "fdir1")) {
        note("fdir1", along,
             who + ": <fdir1> is left out: friction is the same in every direction");
      }
    }
    for (const char* name : {"slip1", "slip2"}) {
      if (number(ode, name, 0) == 0) continue;
      note("slip", child(ode, name),
           who + ": <" + name + "> is left out: what rests does not slip");
    }
    const auto bullet = child(friction, "bullet");
    if (bullet && !child(ode, "mu") && number(bullet, "friction", 1) != 1) {
      note("bullet", bullet,
           who + ": <friction> of <bullet> is left out: only <ode> is read, and <mu> is 1 here");
    }
    if (const auto torsion = child(friction, "torsional")) {
      note("torsional", torsion, who + ": <torsional> friction is left out");
    }
  }

  void look_at_contact(const sdf::ElementPtr& surface, const std::string& who) {
    const auto ode = descendant(surface, {"contact", "ode"});
    for (const char* name : {"soft_cfm", "soft_erp", "max_vel", "min_depth"}) {
      const auto key = child(ode, name);
      if (!key) continue;
      note("contact", key,
           who + ": <" + name +
               "> is left out: of a contact's spring and damper <kp> and <kd> are "
               "read");
      break;
    }
    const auto category = descendant(surface, {"contact", "category_bitmask"});
    if (category && (category->Get<unsigned>() & kEveryBit) != kEveryBit) {
      note("category", category, who + ": <category_bitmask> is left out");
    }
    const auto bounce = descendant(surface, {"bounce", "restitution_coefficient"});
    if (bounce && bounce->Get<double>() > 0) {
      note("bounce", bounce, who + ": <restitution_coefficient> is left out: nothing bounces");
    }
    if (const auto soft = child(surface, "soft_contact")) {
      note("soft", soft, who + ": <soft_contact> is left out: nothing deforms");
    }
  }

  void look_at_geometry(const sdf::ElementPtr& collision, const std::string& who) {
    const sdf::ElementPtr geometry = child(collision, "geometry");
    if (const auto part = descendant(geometry, {"mesh", "submesh"})) {
      note("submesh", part, who + " names a <submesh>; the whole mesh collides here");
    }
    std::string taken;
    for (const char* name : kForms) {
      const auto shape = child(geometry, name);
      if (!shape) continue;
      const std::string left_out = who + ": <" + name + "> is left out: ";
      if (!taken.empty()) {
        note("forms", shape, left_out + "one form of a <geometry> counts, <" + taken + "> here");
      } else if (!is_touched(name)) {
        note("geometry", shape,
             left_out + "box, sphere, cylinder, plane, mesh and heightmap can be touched");
      }
      if (taken.empty()) taken = name;
    }
    if (taken.empty() && !child(geometry, "empty")) {
      note("no form", collision, who + " has no form in its <geometry>: left out");
    }
    look_at_defaults(geometry, who);
  }

  static bool is_touched(std::string_view form) {
    constexpr std::array<std::string_view, 5> kLeftOut{"image", "polyline", "ellipsoid", "capsule",
                                                       "cone"};
    return std::ranges::find(kLeftOut, form) == kLeftOut.end();
  }

  /// A size that the file does not have.
  void look_at_defaults(const sdf::ElementPtr& geometry, const std::string& who) {
    constexpr std::array<std::pair<const char*, const char*>, 4> kSizes{
        {{"box", "size"}, {"sphere", "radius"}, {"cylinder", "radius"}, {"cylinder", "length"}}};
    for (const auto& [form, size] : kSizes) {
      const auto shape = child(geometry, form);
      if (!shape || child(shape, size)) continue;
      note("default", shape, who + ": <" + form + "> has no <" + size + ">: 1 m, as SDF has it");
    }
  }

  template <class Action>
  static void for_each(const sdf::ElementPtr& parent, const char* name, const Action& action) {
    if (!parent->HasElement(name)) return;
    for (sdf::ElementPtr part = parent->GetElement(name); part; part = part->GetNextElement(name)) {
      action(part);
    }
  }

  static std::string named(const sdf::Element& element) {
    const std::string name = name_of(element);
    return name.empty() ? "" : " name='" + name + "'";
  }

  void note(const std::string& kind, const sdf::ElementPtr& at, const std::string& sentence) {
    omissions_.note(kind, *at, sentence);
  }

  Omissions omissions_;
};

}  // namespace

std::string place_of(const sdf::Element& element) {
  const auto line = element.LineNumber();  // 0: element moved by conversion from an older SDF
  return element.FilePath() + (line.value_or(0) > 0 ? fmt::format(":{}", *line) : "");
}

std::vector<std::string> sdf_omissions(const sdf::ElementPtr& world) { return Walk().run(world); }

}  // namespace cas::sim
