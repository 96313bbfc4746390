// SPDX-License-Identifier: BSD-3-Clause
#include "hils/scenario/yaml_text.hpp"

#include <yaml-cpp/yaml.h>

namespace cas::hils {

YAML::Node copy(const base::ConfigNode& node) {
  YAML::Node result = YAML::Load(node.dump());
  return result.IsMap() ? result : YAML::Node(YAML::NodeType::Map);
}

std::string to_text(const YAML::Node& node) {
  YAML::Emitter emitter;
  emitter << node;
  return std::string(emitter.c_str()) + "\n";
}

std::string full_path(const std::filesystem::path& path) {
  return std::filesystem::weakly_canonical(path).string();
}

}  // namespace cas::hils
