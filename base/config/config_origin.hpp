// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <string>
#include <string_view>

#include "base/export.hpp"

namespace cas::base {

class ConfigNode;

/// Lines for the end of a generated YAML file that tell which file of the user's its values came
/// from. A reader of that file names the user's place in errors, not the generated one:
///
///     #: vehicles[0].plugins[5].rate_hz <- /home/me/hover.yaml:12: plugins[0].rate_hz
///
/// @param path  where the generated file has a copy of `from`; empty: at its root, whose keys then
/// have notes
CAS_BASE_EXPORT std::string origin_notes(std::string_view path, const ConfigNode& from);

/// A place in a file of the user's.
struct ConfigOrigin {
  std::string file;
  int line = 0;
  std::string path;

  /// "FILE:LINE: key.path".
  std::string text() const;
};

/// The notes at the end of a generated file: where each value came from.
class ConfigOrigins {
 public:
  /// Lines of `text` that are no notes are passed by.
  static ConfigOrigins read(std::string_view text);

  /// Where the value at this path came from; for a key that has no note, its place below the
  /// nearest one above it that has. @return a place without a file where there is none
  ConfigOrigin of(std::string_view path) const;

 private:
  std::map<std::string, ConfigOrigin, std::less<>> by_path_;
};

}  // namespace cas::base
