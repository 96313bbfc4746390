// SPDX-License-Identifier: BSD-3-Clause
#include "hils/programs/declared_messages.hpp"

#include <algorithm>

#include "base/config/vehicle.hpp"
#include "base/error.hpp"
#include "libsim/core/run/plugin_loader.hpp"
#include "plugins/common/plugin_messages.hpp"

namespace cas::hils {

namespace {

/// What the plugin of a key declares. @throws base::ConfigError at the key
std::vector<std::string> words_of(sim::PluginLoader& loader, const base::ConfigNode& key) {
  try {
    return loader.sends(key.as<std::string>());
  } catch (const base::ConfigError& error) {
    key.fail(error.what());
  }
}

}  // namespace

std::vector<std::string> declared_messages(const Scenario& scenario, std::size_t vehicle) {
  std::vector<std::string> names;
  const auto file = base::ConfigNode::load(scenario.vehicles.at(vehicle).vehicle);
  if (file.has("battery")) names.emplace_back("BATTERY_STATUS");
  const auto is_electric = [](const base::Rotor& rotor) { return rotor.electric.has_value(); };
  if (std::ranges::any_of(base::Vehicle::load(scenario.vehicles[vehicle].vehicle).rotors,
                          is_electric)) {
    names.insert(names.end(), {"ESC_STATUS", "ESC_INFO"});
  }
  sim::PluginLoader loader({});
  for (const base::ConfigNode& further : scenario.plugins) {
    const base::ConfigNode key = further.at("plugin");
    for (const std::string& word : words_of(loader, key)) {
      try {
        const std::string name(sim::declared_message(word).name);
        if (std::ranges::find(names, name) == names.end()) names.push_back(name);
      } catch (const base::ConfigError& error) {
        key.fail("plugin " + key.as<std::string>() + " " + error.what());
      }
    }
  }
  return names;
}

}  // namespace cas::hils
