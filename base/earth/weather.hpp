// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>

#include "base/earth/atmosphere.hpp"
#include "base/export.hpp"

namespace cas::base {

/// Air of a day at home, as an airfield reports it. Values left out are those of the world's air.
struct Weather {
  std::optional<double> temperature_degc{};         ///< at home
  std::optional<double> temperature_offset_degc{};  ///< against the world's air, at every altitude
  std::optional<double> qnh_hpa{};   ///< pressure at home, reduced to sea level as in [ISO 2533]
  std::optional<double> humidity{};  ///< relative, 0..1

  bool operator==(const Weather&) const = default;
};

/// The world's air, changed by the weather.
/// @param home_alt_m  height of home above mean sea level
CAS_BASE_EXPORT Atmosphere air_of(const Weather& weather, const Atmosphere& world,
                                  double home_alt_m);

}  // namespace cas::base
