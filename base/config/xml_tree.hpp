// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/export.hpp"

namespace cas::base {

/// One element of an XML file, without namespaces and comments.
struct CAS_BASE_EXPORT XmlElement {
  std::string name;
  int line = 0;  ///< of its start, from 1
  std::map<std::string, std::string, std::less<>> attributes;
  std::string text;  ///< all character data directly inside
  std::vector<XmlElement> children;
  std::shared_ptr<const std::string> file;  ///< name of its file

  /// The attribute's value; empty when there is none.
  std::string_view attribute(std::string_view key) const;
  /// The first child of that name, or nothing.
  const XmlElement* child(std::string_view child_name) const;
  /// The same. @throws ConfigError when there is none
  const XmlElement& need(std::string_view child_name) const;
  /// The text of that child without blanks at its ends; empty when there is none.
  std::string_view child_text(std::string_view child_name) const;
  /// "FILE:LINE", for errors.
  std::string place() const;
  /// @throws ConfigError "FILE:LINE: sentence"
  [[noreturn]] void fail(const std::string& sentence) const;
  /// The numbers that the element's text is made of. @throws ConfigError unless there are `count`
  std::vector<double> numbers(std::size_t count) const;
  /// The same of an attribute that is there.
  std::vector<double> numbers(std::string_view key, std::size_t count) const;
};

/// A text of an XML file without the white space at its ends.
CAS_BASE_EXPORT std::string_view without_space(std::string_view text);

/// A sentence for a text that a program has to fill in before it is a model: xacro, or ERB and
/// other templates; nullopt for any other. Comments do not count.
CAS_BASE_EXPORT std::optional<std::string> template_language(std::string_view text);

/// Reads a whole XML text of at most a million elements and attributes, at most 200 deep.
/// @throws ConfigError "FILE:LINE: sentence"; of a file that is cut it names the open element
CAS_BASE_EXPORT XmlElement parse_xml(std::string_view text, const std::string& file);

}  // namespace cas::base
