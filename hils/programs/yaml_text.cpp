// SPDX-License-Identifier: BSD-3-Clause
#include "hils/programs/yaml_text.hpp"

#include <fmt/format.h>
#include <yaml-cpp/yaml.h>

namespace cas::hils {

YAML::Node copy(const base::ConfigNode& node) {
  YAML::Node result = YAML::Load(node.dump());
  return result.IsMap() ? result : YAML::Node(YAML::NodeType::Map);
}

void overlay(YAML::Node node, const YAML::Node& own) {
  for (const auto& entry : own) {
    const auto key = entry.first.as<std::string>();
    if (entry.second.IsMap() && node[key] && node[key].IsMap()) {
      overlay(node[key], entry.second);
    } else {
      node[key] = entry.second;
    }
  }
}

std::string to_text(const YAML::Node& node) {
  YAML::Emitter emitter;
  emitter << node;
  return std::string(emitter.c_str()) + "\n";
}

std::string full_path(const std::filesystem::path& path) {
  return std::filesystem::weakly_canonical(path).string();
}

std::string local_port(std::uint16_t port) { return fmt::format("127.0.0.1:{}", port); }

const char* pace_word(const RunRequest& request) {
  return request.lockstep ? "lockstep" : "realtime";
}

}  // namespace cas::hils
