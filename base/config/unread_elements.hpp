// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <span>
#include <string_view>

#include "base/config/model_builder.hpp"
#include "base/config/xml_tree.hpp"

namespace cas::base {

/// Children and attributes that a format allows in an element: names with a blank between them.
struct KnownElement {
  std::string_view element;
  std::string_view single;  ///< children of which the first counts
  std::string_view many;    ///< further children
  std::string_view attributes;
};

/// Warns of unread parts of an element and of the elements in it: attributes and children that the
/// table does not have, such as misspelt ones (<orgin>), and repeated children, of which the first
/// counts. An element without a row may hold anything; of a <geometry> only the first form is
/// checked. Names of other programs' namespaces are skipped.
/// @param visit  is called with each child, and says whether to look into it
void warn_of_unread(
    const XmlElement& element, std::span<const KnownElement> rows, ModelBuilder& builder,
    const std::function<bool(const XmlElement&)>& visit = [](const XmlElement&) { return true; });

/// An element's tag for a sentence: "<link name='arm'>", "<sphere>".
std::string tag_of(const XmlElement& element);

}  // namespace cas::base
