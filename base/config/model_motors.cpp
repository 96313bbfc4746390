// SPDX-License-Identifier: BSD-3-Clause
#include "base/config/model_motors.hpp"

#include <array>
#include <utility>

namespace cas::base {
namespace {

/// Elements of the plugin, and the keys of the vehicle file that mean the same in the same unit.
constexpr std::array<std::pair<const char*, const char*>, 6> kKeys{{
    {"motorConstant", "thrust_coefficient"},
    {"maxRotVelocity", "omega_max_rad_s"},
    {"timeConstantUp", "time_constant_up_s"},
    {"timeConstantDown", "time_constant_down_s"},
    {"rotorDragCoefficient", "drag_coefficient"},
    {"rollingMomentCoefficient", "rolling_moment_coefficient"},
}};

std::string named(std::string_view name, const std::string& prefix) {
  return name.empty() ? std::string() : prefix + std::string(name);
}

}  // namespace

std::optional<ModelMotor> read_model_motor(const XmlElement& plugin, const std::string& prefix) {
  if (plugin.child("motorConstant") == nullptr) return std::nullopt;
  ModelMotor motor{.place = plugin.place(),
                   .link = named(plugin.child_text("linkName"), prefix),
                   .joint = named(plugin.child_text("jointName"), prefix)};
  for (const auto& [element, key] : kKeys) {
    if (const XmlElement* const found = plugin.child(element)) {
      motor.keys[key] = found->numbers(1)[0];
    }
  }
  // The motor's torque is momentConstant times its thrust.
  if (const XmlElement* const moment = plugin.child("momentConstant")) {
    motor.keys["torque_coefficient"] = moment->numbers(1)[0] * motor.keys["thrust_coefficient"];
  }
  const std::string_view turning = plugin.child_text("turningDirection");
  if (turning == "ccw") motor.spin = 1;
  if (turning == "cw") motor.spin = -1;
  const std::string_view reversible = plugin.child_text("reversible");
  motor.reversible = reversible == "true" || reversible == "1";
  return motor;
}

}  // namespace cas::base
