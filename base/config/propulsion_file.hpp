// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string_view>

#include "base/config/config.hpp"
#include "base/config/missing_keys.hpp"
#include "base/config/vehicle.hpp"

namespace cas::base {

/// Block `key` of a rotor: its own, or the one in `rotor` that counts for all.
std::optional<ConfigNode> rotor_block(const ConfigNode& item, const ConfigNode& common,
                                      std::string_view key);
/// Whether a block of this rotor stands for that key of a rotor: `propeller` for its coefficients,
/// `electric` for lag and fastest speed.
bool is_replaced(const ConfigNode& item, const ConfigNode& common, std::string_view key);
/// Keys that must be there and are not, of these blocks of a rotor or of `rotor`.
void need_propulsion_keys(const ConfigNode& rotor, MissingKeys& missing);
void need_battery_keys(const ConfigNode& battery, bool electric, MissingKeys& missing);

/// Sets `propeller` and what it says in `params`, where the file has one.
/// @param rotor  with the rest of its params
/// @throws ConfigError for keys that it replaces, a bad curve, or a file that cannot be read
void read_propeller(const ConfigNode& item, const ConfigNode& common, Rotor& rotor);
/// The same for `electric`: also the fastest speed. The lag is settle_lags()'.
/// @param battery  that feeds the circuit
void read_electric(const ConfigNode& item, const ConfigNode& common,
                   const std::optional<BatteryParams>& battery, Rotor& rotor);
/// @param electric  whether rotors have circuits, so that there is no `efficiency`
BatteryParams read_battery(const ConfigNode& node, bool electric);

}  // namespace cas::base
