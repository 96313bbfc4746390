// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "mavlink_gen/parser/diagnostics.hpp"

namespace cas::mav::xml {

struct Attribute {
  std::string name;
  std::string value;
  Position position;  ///< of the first character of the name
};

/// An element with its attributes, child elements and all its own text run together.
struct Element {
  std::string name;
  std::string text;
  Position position;       ///< of the opening '<'
  Position text_position;  ///< of the first character that is no white space
  std::vector<Attribute> attributes;
  std::vector<Element> children;

  const Attribute* find(std::string_view attribute) const;
};

/// Parses XML text. Documents with a DOCTYPE are refused, so no entity can grow or reach outside
/// the file.
/// @return the root element, or nullptr after an error has been reported
std::unique_ptr<Element> parse_xml(std::string_view text, std::uint32_t file,
                                   Diagnostics& diagnostics);

}  // namespace cas::mav::xml
