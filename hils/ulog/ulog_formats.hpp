// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "hils/ulog/read_ulog.hpp"

namespace cas::hils {

inline constexpr std::size_t kMostUlogBytes = 65535;  ///< of a message
inline constexpr std::size_t kMostUlogNameBytes = 255;

/// A type that the format itself has.
struct UlogBasicType {
  std::string_view name;
  UlogField::Type type;
  std::size_t size;
};

/// @return nullptr: there is none of this name
const UlogBasicType* ulog_basic_type(std::string_view name);
std::size_t ulog_size_of(UlogField::Type type);

/// "float[3] xyz": type, how many (nothing: no array), name.
struct UlogDeclaration {
  std::string type;
  std::optional<std::size_t> count;
  std::string name;
};

std::optional<UlogDeclaration> ulog_declaration(std::string_view text);

/// The types that a log defines, by name, as their fields.
class UlogFormats {
 public:
  /// @param text  "name:type field;type field;" @throws base::ConfigError
  void add(std::string_view text);
  bool has(const std::string& topic) const { return formats_.contains(topic); }
  /// The numbers of a topic's messages. @throws base::ConfigError
  const std::vector<UlogField>& spread(const std::string& topic);
  /// Bytes of a topic that was spread out, with its padding.
  std::size_t bytes_of(const std::string& topic) const { return bytes_.at(topic); }

 private:
  std::size_t spread(const std::string& type, const std::string& prefix, std::size_t offset,
                     int depth, std::vector<UlogField>& out);

  std::map<std::string, std::vector<UlogDeclaration>> formats_;
  std::map<std::string, std::vector<UlogField>> spread_;  ///< topics so far
  std::map<std::string, std::size_t> bytes_;              ///< of theirs
  std::size_t steps_ = 0;                                 ///< taken for all of them
};

}  // namespace cas::hils
