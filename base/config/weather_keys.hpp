// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <tuple>

#include "base/config/config_keys.hpp"
#include "base/earth/weather.hpp"

namespace cas::base {

/// Keys of block `weather`.
inline constexpr std::tuple kWeatherKeys{
    key<&Weather::temperature_degc>("temperature_degc", Range{-90, 60}, "of the air at home",
                                    "the world's"),
    key<&Weather::temperature_offset_degc>(
        "temperature_offset_degc", Range{-80, 80},
        "of the air at every altitude, against the world's; or `temperature_degc`", "none"),
    key<&Weather::qnh_hpa>("qnh_hpa", Range{850, 1100},
                           "pressure at home, reduced to sea level by the standard atmosphere",
                           "the world's"),
    key<&Weather::humidity>("humidity", Range{0, 1}, "relative, at every altitude", "0"),
};

/// @throws ConfigError if a block gives the temperature twice
inline void check_weather(const ConfigNode& node, const Weather& weather) {
  if (!weather.temperature_degc || !weather.temperature_offset_degc) return;
  node.at("temperature_offset_degc").fail("the temperature is given by 'temperature_degc' already");
}

/// Block `weather` of simulations and scenarios.
inline constexpr auto kWeatherBlock = block<Weather>(kWeatherKeys, check_weather);

}  // namespace cas::base
