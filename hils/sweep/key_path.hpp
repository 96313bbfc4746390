// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace cas::hils {

/// One step of a key path, as errors of configuration files name places: "faults[0]", and also
/// "plugins[wind]", the entry of a list whose `name` or `plugin` is that word, and "steps[hold]",
/// whose only key it is.
struct KeyStep {
  std::string key{};
  std::optional<std::string> element{};  ///< index or word

  bool operator==(const KeyStep&) const = default;
};

/// "plugins[wind].mean_m_s" in steps. @throws base::ConfigError with the path
std::vector<KeyStep> parse_key_path(std::string_view path);

/// A key path and the YAML text that it gets; "null" takes the key away.
using KeyValue = std::pair<std::string, std::string>;

/// Writes `folder`/scenario.yaml: the scenario with other values.
///
/// A path may lead through a key that names a file ("vehicle.rotor.thrust_coefficient"): a changed
/// copy of that file is then written beside the scenario. Through the name of a sensor set
/// ("sensors.imu...") it leads into the keys that differ from it. Maps that are not there are made.
/// Names of files become absolute paths, so that they lead to the same files as before.
///
/// @param files_from  further folder that values may name files in
/// @param copied      keys whose files are copied, too: "vehicle"
/// @throws base::ConfigError when a path leads nowhere, or a file cannot be read or written
void write_scenario(const std::filesystem::path& scenario, const std::vector<KeyValue>& values,
                    const std::filesystem::path& files_from, const std::filesystem::path& folder,
                    const std::vector<std::string>& copied = {});

}  // namespace cas::hils
