// SPDX-License-Identifier: BSD-3-Clause
#include "libsim/core/load/sdf_numbers.hpp"

#include <algorithm>
#include <array>
#include <string>
#include <string_view>

#include "base/error.hpp"
#include "base/number_text.hpp"
#include "base/text.hpp"
#include "libsim/core/load/sdf_omissions.hpp"

namespace cas::sim {

namespace {

/// Elements whose numbers nobody asks for here.
constexpr std::array<std::string_view, 18> kWithoutEffect{
    "visual", "light",      "gui",  "scene", "sensor",  "plugin",   "joint",     "gripper",
    "state",  "population", "road", "audio", "battery", "inertial", "projector", "particle_emitter",
    "skin",   "animation"};

bool is_integer(std::string_view type) { return type == "int" || type == "unsigned int"; }

/// How many numbers a type has; 0 for types that are no numbers.
std::size_t numbers_of(std::string_view type) {
  if (type == "double" || type == "float" || is_integer(type)) return 1;
  if (type == "vector3") return 3;
  return type == "pose" ? 7 : 0;  // a quaternion makes seven; libsdformat counts
}

/// "0xFFFF", as bitmasks are written.
bool is_hexadecimal(std::string_view word) {
  const std::string_view digits =
      word.starts_with("0x") || word.starts_with("0X") ? word.substr(2) : std::string_view();
  return !digits.empty() && digits.find_first_not_of("0123456789abcdefABCDEF") == digits.npos;
}

/// Infinity is one here: a friction may be infinite.
bool is_number(std::string_view word) {
  if (base::number_of<double>(word) || is_hexadecimal(word)) return true;
  std::string small = base::lower(word);
  if (small.starts_with('-') || small.starts_with('+')) small.erase(0, 1);
  return small == "inf" || small == "infinity";
}

void check(const sdf::Element& element, const sdf::Param& value) {
  const std::size_t wanted = numbers_of(value.GetTypeName());
  if (wanted == 0 || !value.GetSet()) return;
  const auto fail = [&](const std::string& sentence) {
    throw base::ConfigError(place_of(element) + ": <" + element.GetName() + ">" + sentence);
  };
  const std::string text = value.GetAsString();
  std::string_view rest = text;
  std::size_t count = 0;
  for (auto word = base::next_word(rest); !word.empty(); word = base::next_word(rest), ++count) {
    if (!is_number(word)) fail(": " + base::no_number(word));
  }
  if (count > wanted) {
    fail(" has " + std::to_string(count) + " numbers instead of " + std::to_string(wanted));
  }
}

}  // namespace

bool has_no_effect(std::string_view element) {
  return std::ranges::find(kWithoutEffect, element) != kWithoutEffect.end();
}

void require_whole_numbers(const sdf::ElementPtr& world) {
  for (auto part = world->GetFirstElement(); part; part = part->GetNextElement()) {
    if (has_no_effect(part->GetName())) continue;
    if (const auto value = part->GetValue()) check(*part, *value);
    require_whole_numbers(part);
  }
}

}  // namespace cas::sim
