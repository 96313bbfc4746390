// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "base/time/clock.hpp"

namespace cas::test {

/// The [Service] and [Unit] settings of a systemd unit file, as far as a supervisor of one program
/// needs them (systemd.service(5), systemd.unit(5)).
struct UnitFile {
  /// @throws std::runtime_error when it cannot be read
  static UnitFile load(const std::filesystem::path& file);

  /// The last value of a key; `fallback` when the file does not have it.
  std::string value(const std::string& key, const std::string& fallback = "") const;
  /// All values of a key, for keys that add up (ExecStartPre).
  std::vector<std::string> all(const std::string& key) const;
  /// A time span: "20ms", "1min 5s", a number of seconds. @throws std::runtime_error otherwise
  base::Duration span(const std::string& key, const std::string& fallback) const;

  std::map<std::string, std::vector<std::string>> settings;
};

/// "1min 30s", "20ms", "2" (seconds) of systemd.time(7). @throws std::runtime_error otherwise
base::Duration parse_span(const std::string& text);

}  // namespace cas::test
