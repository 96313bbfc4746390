// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "libsim/api/plugin.hpp"
#include "libsim/core/export.hpp"

namespace cas::sim {

/// Destroys a plugin in the library that made it.
struct PluginDeleter {
  const PluginDescriptor* descriptor = nullptr;
  void operator()(Plugin* plugin) const { descriptor->destroy(plugin); }
};
using PluginPtr = std::unique_ptr<Plugin, PluginDeleter>;

/// Opens plugin libraries by bare name and makes plugins. A library stays open until the process
/// ends: its code may be on other threads' stacks and its logger in the registry.
class CAS_SIM_EXPORT PluginLoader {
 public:
  /// @param first_dirs  searched before CAS_PLUGIN_PATH and the folder that belongs to this library
  explicit PluginLoader(std::vector<std::filesystem::path> first_dirs);

  /// Finds lib<name>.so, opens it once, checks its descriptor and creates a plugin.
  /// @throws base::ConfigError that names the file and the fault
  PluginPtr create(const std::string& name);
  /// The MAVLink messages that the plugin declares, by name or id; empty when it declares none.
  /// @throws base::ConfigError as create(), and for a declaration that cannot be one
  std::vector<std::string> sends(const std::string& name);

 private:
  const PluginDescriptor& open(const std::string& name);
  std::filesystem::path find(const std::string& name) const;

  std::vector<std::filesystem::path> dirs_;
  std::map<std::string, const PluginDescriptor*> open_;
};

}  // namespace cas::sim
