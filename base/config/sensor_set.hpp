// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "base/config/config.hpp"
#include "base/export.hpp"

namespace cas::base {

/// Parameters of the sensor plugins, a map by plugin name. `node` is the name of a shipped set
/// ("rtk": sensors/rtk.yaml), a file of that form, or a map of the keys that differ from the set
/// that it names in `preset`, or else from `behind`. Key `sensors` has the same form in vehicle
/// files, simulations, controller files and scenarios.
/// @throws ConfigError when there is no such set
CAS_BASE_EXPORT ConfigNode sensor_set(const ConfigNode& node,
                                      const ConfigNode& behind = ConfigNode::empty());

/// Kind of a key (config_keys.hpp): a set, or keys that differ from the one that the member holds.
struct SensorSet {
  static void read(const ConfigNode& node, ConfigNode& set) { set = sensor_set(node, set); }
};

}  // namespace cas::base
