// SPDX-License-Identifier: BSD-3-Clause
#include "base/sensor_set.hpp"

#include <filesystem>
#include <string>

#include "base/install_paths.hpp"

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

/// The set that the word names, of the shipped ones or a file.
ConfigNode load_sensor_set(const ConfigNode& node) {
  const auto word = node.as<std::string>();
  const auto beside = node.resolve(word);
  std::error_code error;
  std::filesystem::path file = beside;
  if (std::filesystem::path(word).extension().empty()) {
    file = find_config("sensors/" + word + ".yaml");
  } else if (!std::filesystem::exists(beside, error)) {
    file = find_config(word);
  }
  ConfigNode presets = ConfigNode::load(file);
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
