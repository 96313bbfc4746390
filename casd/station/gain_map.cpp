// SPDX-License-Identifier: BSD-3-Clause
#include "casd/station/gain_map.hpp"

#include <utility>

#include "base/config/config.hpp"
#include "base/config/install_paths.hpp"

namespace cas::casd {
namespace {

constexpr std::pair<const char*, Autopilot> kAutopilots[] = {
    {"px4", Autopilot::kPx4},
    {"ardupilot", Autopilot::kArduPilot},
};
constexpr std::size_t kParamNameBytes = 16;

std::optional<std::string> parse_name(const base::ConfigNode& node, std::string_view key) {
  const std::optional<base::ConfigNode> child = node.find(key);
  if (!child) return std::nullopt;
  const std::string name = child->as<std::string>();
  if (name.empty() || name.size() > kParamNameBytes) {
    child->fail("a parameter name has 1 to 16 characters");
  }
  return name;
}

GainLoop parse_loop(const std::string& name, const base::ConfigNode& node) {
  GainLoop loop{name, parse_name(node, "p"), parse_name(node, "i"), parse_name(node, "d")};
  if (!loop.p && !loop.i && !loop.d) node.fail("the loop names no gain; give p, i or d");
  return loop;
}

}  // namespace

std::optional<std::string> unsupported(const GainLoop& loop, const GainValues& values) {
  std::string has;
  std::string lacks;
  const auto look = [&](const char* letter, const std::optional<std::string>& name, bool asked) {
    if (name) has += has.empty() ? letter : std::string(", ") + letter;
    if (!name && asked) lacks += lacks.empty() ? letter : std::string(" and no ") + letter;
  };
  look("P", loop.p, values.p.has_value());
  look("I", loop.i, values.i.has_value());
  look("D", loop.d, values.d.has_value());
  if (lacks.empty()) return std::nullopt;
  return "loop " + loop.name + " has no " + lacks + " gain; it has " + has;
}

GainMap GainMap::load(const std::filesystem::path& file) {
  return parse(base::ConfigNode::load(file));
}

GainMap GainMap::shipped() {
  for (const std::filesystem::path& folder : base::config_dirs()) {
    if (std::filesystem::exists(folder / "gains.yaml")) return load(folder / "gains.yaml");
  }
  return {};
}

GainMap GainMap::parse(const base::ConfigNode& node) {
  if (node.require<int>("schema") != 1) node.at("schema").fail("this casd reads schema 1");
  GainMap map;
  for (const auto& [key, autopilot] : kAutopilots) {
    const std::optional<base::ConfigNode> block = node.find(key);
    if (!block) continue;
    for (const auto& [name, loop] : block->entries()) {
      map.loops_[autopilot].push_back(parse_loop(name, loop));
    }
  }
  node.reject_unused();
  return map;
}

const GainLoop* GainMap::find(Autopilot autopilot, std::string_view loop) const {
  for (const GainLoop& entry : loops(autopilot)) {
    if (entry.name == loop) return &entry;
  }
  return nullptr;
}

const std::vector<GainLoop>& GainMap::loops(Autopilot autopilot) const {
  static const std::vector<GainLoop> kNone;
  const auto found = loops_.find(autopilot);
  return found == loops_.end() ? kNone : found->second;
}

}  // namespace cas::casd
