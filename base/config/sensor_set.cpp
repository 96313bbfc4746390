// SPDX-License-Identifier: BSD-3-Clause
#include "base/config/sensor_set.hpp"

#include <filesystem>
#include <map>
#include <string>
#include <system_error>

#include "base/config/install_paths.hpp"
#include "base/suggestion.hpp"
#include "base/text.hpp"

namespace cas::base {

namespace {

constexpr int kSchema = 1;

void check_schema(const ConfigNode& set) {
  if (set.require<int>("schema") != kSchema) {
    set.at("schema").fail("this program reads schema " + std::to_string(kSchema));
  }
}

void check_blocks(const ConfigNode& presets) {
  for (const auto& [plugin, preset] : presets.entries()) {
    const bool is_about_the_file =
        plugin == "schema" || plugin == "description" || plugin == "preset";
    if (!preset.is_map() && !is_about_the_file) {
      preset.fail("must be a map of the plugin's parameters");
    }
  }
}

/// Files of the shipped sets by their names. For a name in several folders the first folder's file
/// counts. @throws ConfigError when a folder is there and cannot be listed
std::map<std::string, std::filesystem::path> shipped_sets() {
  std::map<std::string, std::filesystem::path> sets;
  for (const std::filesystem::path& folder : config_dirs()) {
    const std::filesystem::path sheets = folder / "sensors";
    std::error_code error;
    std::filesystem::directory_iterator entry(sheets, error);
    for (; !error && entry != std::filesystem::directory_iterator(); entry.increment(error)) {
      const std::filesystem::path& file = entry->path();
      if (file.extension() == ".yaml") sets.emplace(file.stem().string(), file);
    }
    if (error && error != std::errc::no_such_file_or_directory) {
      throw ConfigError(sheets.string() + ": cannot be listed: " + error.message());
    }
  }
  return sets;
}

std::filesystem::path shipped_set(const ConfigNode& node) {
  const auto sets = shipped_sets();
  const auto word = node.as<std::string>();
  const auto found = sets.find(word);
  if (found != sets.end()) return found->second;
  std::vector<std::string_view> names;
  names.reserve(sets.size());
  for (const auto& [name, file] : sets) names.push_back(name);
  node.fail("there is no sensor set '" + word + "'; sets are " + joined(names, ", ") +
            did_you_mean(word, names));
}

/// The set that the word names, of the shipped ones or a file.
ConfigNode load_sensor_set(const ConfigNode& node) {
  const bool is_name = std::filesystem::path(node.as<std::string>()).extension().empty();
  ConfigNode presets = ConfigNode::load(is_name ? shipped_set(node) : find_config(node));
  check_schema(presets);
  presets.require<std::string>("description");
  check_blocks(presets);
  presets.mark_used();  // each plugin checks its own block
  return presets;
}

}  // namespace

ConfigNode sensor_set(const ConfigNode& node, const ConfigNode& behind) {
  if (node.is_scalar()) return load_sensor_set(node);
  const auto preset = node.find("preset");
  const ConfigNode set = node.merged_over(preset ? load_sensor_set(*preset) : behind);
  check_blocks(set);
  set.mark_used();  // each plugin checks its own block
  return set;
}

}  // namespace cas::base
