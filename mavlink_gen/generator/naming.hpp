// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "mavlink_gen/parser/model.hpp"

namespace cas::mav::gen {

/// `HIL_SENSOR` -> `HilSensor`; an underscore stays where two digits would meet.
std::string pascal_case(std::string_view name);
std::string lower_case(std::string_view name);

/// Namespace and folder of a dialect: lower case, with an underscore for each invalid character.
std::string namespace_of(std::string_view dialect);

/// `name`, with an underscore behind it where it is a C++ keyword, a common macro, or a name that
/// the generated struct uses itself.
std::string safe_identifier(std::string_view name);

/// C++ names of everything in a dialect. They depend on the names in the XML alone.
class Names final {
 public:
  explicit Names(const xml::Dialect& dialect);

  const std::string& type(const xml::Message& message) const { return messages_.at(message.name); }
  const std::string& type(const xml::Enum& item) const { return enums_.at(item.name); }
  /// Members of a message's struct, in the order of its fields; no two are the same.
  std::vector<std::string> members(const xml::Message& message) const;

  /// Header of a message without folder: `hil_sensor.hpp`.
  std::string header(const xml::Message& message) const;

  /// Enumerator of each entry, in the order of the entries. An entry loses the leading words that
  /// it shares with its enum: MAV_RESULT_ACCEPTED of MAV_RESULT -> kAccepted.
  static std::vector<std::string> enumerators(const xml::Enum& item);

 private:
  std::map<std::string, std::string, std::less<>> messages_;
  std::map<std::string, std::string, std::less<>> enums_;
  std::map<std::string, std::string, std::less<>> headers_;
  std::map<std::string, int, std::less<>> types_;
};

}  // namespace cas::mav::gen
