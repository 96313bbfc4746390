// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "base/config/config_origin.hpp"

namespace cas::base {

/// Largest YAML text that is read.
inline constexpr std::size_t kMaxConfigBytes = std::size_t{4} << 20U;

/// One node of a parsed YAML document: the data behind ConfigNode.
struct ConfigTree {
  enum class Kind { kNull, kScalar, kList, kMap };

  Kind kind = Kind::kNull;
  int line = 0;                                    // from 1; of the key for a map's entry
  std::string scalar;                              // kScalar
  bool quoted = false;                             // kScalar: never a number or a bool
  std::vector<std::unique_ptr<ConfigTree>> items;  // kList
  std::vector<std::pair<std::string, std::unique_ptr<ConfigTree>>> entries;  // kMap, file order
  std::map<std::string, std::size_t, std::less<>> places;  // kMap: of each key in `entries`

  // Marks of readers: reading is const, and marks are not part of the value.
  mutable bool used = false;                // it was read
  mutable bool opaque = false;              // another program's block: checked by its own reader
  mutable std::vector<std::string> wanted;  // kMap: keys that were read

  const ConfigTree* find(std::string_view key) const;
};

/// A YAML text and where it came from. The tree holds no aliases: each use of an anchor is a copy.
struct ConfigDocument {
  std::filesystem::path file;
  ConfigTree root;
  ConfigOrigins origins;  ///< of a generated file: where its values came from
};

/// @throws ConfigError "NAME:LINE: sentence" for a text that is no YAML, repeats a key, holds more
/// than one document or than kMaxConfigBytes, nests deeper than 64 levels or expands to more than
/// 50 000 nodes
std::shared_ptr<const ConfigDocument> parse_config(std::string_view text,
                                                   const std::filesystem::path& name);

/// The tree as YAML text.
std::string dump_config(const ConfigTree& tree);

}  // namespace cas::base
