// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <tuple>

#include "base/config/config_keys.hpp"
#include "base/earth/geodesy.hpp"

namespace cas::base {

/// Keys of a place on Earth, each of which must be given, whose altitude lies in [low_m, high_m].
constexpr auto geodetic_keys(double low_m, double high_m) {
  return std::tuple{
      required(key<&Geodetic::lat_deg>("lat_deg", Range{-90, 90}, "latitude, to the north")),
      required(key<&Geodetic::lon_deg>("lon_deg", Range{-180, 180}, "longitude, to the east")),
      required(key<&Geodetic::alt_m>("alt_m", Range{low_m, high_m}, "above mean sea level"))};
}

}  // namespace cas::base
