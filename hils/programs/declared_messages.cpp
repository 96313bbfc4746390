// SPDX-License-Identifier: BSD-3-Clause
#include "hils/programs/declared_messages.hpp"

#include <algorithm>

#include "base/error.hpp"
#include "libsim/core/run/plugin_loader.hpp"
#include "plugins/mavlink_interface/plugin_messages.hpp"

namespace cas::hils {

std::vector<std::string> declared_messages(const Scenario& scenario, std::size_t vehicle) {
  std::vector<std::string> names;
  const auto file = base::ConfigNode::load(scenario.vehicles.at(vehicle).vehicle);
  if (file.has("battery")) names.emplace_back("BATTERY_STATUS");
  sim::PluginLoader loader({});
  for (const base::ConfigNode& further : scenario.plugins) {
    const base::ConfigNode key = further.at("plugin");
    const auto plugin = key.as<std::string>();
    try {
      for (const std::string& word : loader.sends(plugin)) {
        const std::string name(sim::declared_message(word).name);
        if (std::ranges::find(names, name) == names.end()) names.push_back(name);
      }
    } catch (const base::ConfigError& error) {
      const std::string reason = error.what();
      key.fail(reason.starts_with("declares ") ? "plugin " + plugin + " " + reason : reason);
    }
  }
  return names;
}

}  // namespace cas::hils
