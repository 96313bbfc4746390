// SPDX-License-Identifier: BSD-3-Clause
#include "base/config/urdf_unread.hpp"

#include <algorithm>
#include <array>
#include <set>
#include <string_view>

#include "base/number_text.hpp"

namespace cas::base {
namespace {

/// An element whose children and attributes are known; those of any other may be anything.
struct UrdfElement {
  std::string_view element;
  std::string_view children;  ///< words
  std::string_view attributes;
};

constexpr std::array<UrdfElement, 14> kUrdfElements{
    {{"inertial", "origin mass inertia", "name"},
     {"collision", "origin geometry material verbose contact_coefficients", "name group concave"},
     {"visual", "origin geometry material", "name"},
     {"joint",
      "origin parent child axis limit dynamics mimic calibration safety_controller "
      "joint_properties",
      "name type"},
     {"origin", "", "xyz rpy"},
     {"axis", "", "xyz rpy"},
     {"parent", "", "link"},
     {"child", "", "link"},
     {"mass", "", "value"},
     {"inertia", "", "ixx ixy ixz iyy iyz izz"},
     {"box", "", "size"},
     {"sphere", "", "radius"},
     {"cylinder", "", "radius length"},
     {"mesh", "", "filename scale"}}};

bool is_word_of(std::string_view words, std::string_view word) {
  for (auto each = next_word(words); !each.empty(); each = next_word(words)) {
    if (each == word) return true;
  }
  return false;
}

bool has_prefix(std::string_view name) { return name.find(':') != name.npos; }

}  // namespace

void warn_of_unread_urdf(const XmlElement& part, const std::string& who, ModelBuilder& builder) {
  const auto known = std::ranges::find(kUrdfElements, part.name, &UrdfElement::element);
  if (known == kUrdfElements.end()) return;
  const std::string end = " of <" + part.name + "> is left out";
  for (const auto& [key, value] : part.attributes) {
    if (has_prefix(key) || is_word_of(known->attributes, key)) continue;
    builder.warn(part, who + ": '" + key + "'" + end + ": no URDF has it there");
  }
  std::set<std::string_view> met;
  for (const XmlElement& child : part.children) {
    const std::string what = "<" + child.name + ">" + end;
    if (has_prefix(child.name)) continue;
    if (!is_word_of(known->children, child.name)) {
      builder.warn(child, who + ": " + what + ": no URDF has it there");
    } else if (!met.insert(child.name).second) {
      builder.warn(child, who + ": a second " + what);
    } else if (child.name != "geometry") {
      warn_of_unread_urdf(child, who, builder);
    } else if (!child.children.empty()) {
      warn_of_unread_urdf(child.children.front(), who, builder);  // the form that counts
    }
  }
}

}  // namespace cas::base
