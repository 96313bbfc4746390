// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <string>

#include "base/config/config.hpp"
#include "hils/scenario/scenario.hpp"

namespace cas::hils {

/// Kind of a key (base/config/config_keys.hpp) whose value names an architecture.
struct ArchitectureWord {
  static void read(const base::ConfigNode& node, Architecture& architecture) try {
    architecture = parse_architecture(node.as<std::string>());
  } catch (const base::ConfigError& error) {
    node.fail(error.what());
  }
  static std::string text(Architecture architecture) {
    return std::string(to_string(architecture));
  }
  static std::string values() { return "tcas, loop, ts, sitl, direct"; }
  static std::array<std::string, 2> samples() { return {"direct", "tcas"}; }
};

}  // namespace cas::hils
