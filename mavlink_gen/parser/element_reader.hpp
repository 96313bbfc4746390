// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>
#include <string>
#include <string_view>

#include "mavlink_gen/parser/diagnostics.hpp"
#include "mavlink_gen/parser/model.hpp"
#include "mavlink_gen/parser/xml_document.hpp"

namespace cas::mav::xml {

/// The text without white space at its ends.
std::string trimmed(std::string_view text);

/// The text with each run of white space as one blank.
std::string prose(std::string_view text);

/// The text in quotation marks, for diagnostics.
std::string in_quotes(std::string_view text);

/// Reads the parts that all elements of a dialect file share, and reports violations of the schema.
class ElementReader final {
 public:
  using Names = std::span<const std::string_view>;

  explicit ElementReader(Diagnostics& diagnostics) : diagnostics_(diagnostics) {}

  /// Whether `child` may stand in `parent`; an error with a suggestion if not.
  bool expect_child(const Element& parent, const Element& child, Names allowed);

  /// Warns of each attribute that is not among the allowed ones.
  void expect_attributes(const Element& element, Names allowed);

  /// The attribute, or nullptr and an error.
  const Attribute* require(const Element& element, std::string_view name);

  /// The attribute `name` as an identifier, empty after an error.
  std::string require_name(const Element& element);

  /// The attribute's text, empty where there is none.
  static std::string value_of(const Element& element, std::string_view name);

  /// A flag that is false unless it says true or 1; a warning for other words.
  bool parse_flag(const Element& element, std::string_view name);

  /// Takes a description or a lifecycle mark; false for any other child.
  bool parse_common_child(const Element& child, std::string& text, Lifecycle& lifecycle);

  void error(const Position& position, const std::string& sentence);
  void warning(const Position& position, const std::string& sentence);

 private:
  Lifecycle parse_lifecycle(const Element& element);

  Diagnostics& diagnostics_;
};

}  // namespace cas::mav::xml
