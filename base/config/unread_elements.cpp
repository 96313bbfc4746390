// SPDX-License-Identifier: BSD-3-Clause
#include "base/config/unread_elements.hpp"

#include <algorithm>
#include <set>
#include <string>

#include "base/number_text.hpp"

namespace cas::base {
namespace {

bool has_word(std::string_view names, std::string_view name) {
  for (auto word = next_word(names); !word.empty(); word = next_word(names)) {
    if (word == name) return true;
  }
  return false;
}

/// Whether a name belongs to another program's namespace or to XML itself.
bool is_foreign(std::string_view name) { return name.find(':') != name.npos || name == "xmlns"; }

/// Walks through an element and what it contains.
class Look {
 public:
  Look(std::span<const KnownElement> rows, ModelBuilder& builder,
       const std::function<bool(const XmlElement&)>& visit)
      : rows_(rows), builder_(builder), visit_(visit) {}

  /// @param owner  " of <link name='arm'>": the nearest element above that has a name
  void into(const XmlElement& element, std::string owner) {
    const auto row = std::ranges::find(rows_, element.name, &KnownElement::element);
    if (row == rows_.end()) return;
    if (!element.attribute("name").empty()) owner.clear();
    const std::string place = tag_of(element) + owner;
    if (owner.empty()) owner = " of " + place;
    for (const auto& [key, value] : element.attributes) {
      if (is_foreign(key) || has_word(row->attributes, key)) continue;
      builder_.warn(element, "'" + key + "' of " + place + " is left out: no such attribute");
    }
    std::set<std::string_view> met;
    for (const XmlElement& child : element.children) {
      const bool goes_on = visit_(child);
      if (is_foreign(child.name)) continue;
      const std::string what = "<" + child.name + "> in " + place + " is left out";
      const bool single = has_word(row->single, child.name);
      if (!single && !has_word(row->many, child.name)) {
        builder_.warn(child, what + ": no such element");
      } else if (single && !met.insert(child.name).second) {
        builder_.warn(child, "a second " + what);
      } else if (child.name == "geometry" && !child.children.empty()) {
        into(child.children.front(), owner);
      } else if (goes_on) {
        into(child, owner);
      }
    }
  }

 private:
  std::span<const KnownElement> rows_;
  ModelBuilder& builder_;
  const std::function<bool(const XmlElement&)>& visit_;
};

}  // namespace

std::string tag_of(const XmlElement& element) {
  const std::string_view name = element.attribute("name");
  return "<" + element.name + (name.empty() ? "" : " name='" + std::string(name) + "'") + ">";
}

void warn_of_unread(const XmlElement& element, std::span<const KnownElement> rows,
                    ModelBuilder& builder, const std::function<bool(const XmlElement&)>& visit) {
  Look(rows, builder, visit).into(element, {});
}

}  // namespace cas::base
