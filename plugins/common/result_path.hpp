// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <string>

#include "base/config/config.hpp"
#include "base/os/result_file.hpp"

namespace cas::sim {

/// A path that a simulation file gives for a plugin's output: below PluginContext::output_dir().
/// The functions of base/os/result_file.hpp write it.
/// @throws base::ConfigError, with the key's path, when it is absolute or has ".."
inline std::filesystem::path result_path(const base::ConfigNode& node) {
  const std::filesystem::path path = node.as<std::string>();
  if (const auto fault = base::fault_of_result_path(path); !fault.empty()) {
    node.fail("'" + path.string() + "' " + std::string(fault));
  }
  return path;
}

}  // namespace cas::sim
