// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <string_view>

namespace cas::hils {

/// Root mean squares of the distance from a reference, per axis.
struct RmsFigures {
  double x_m = 0;
  double y_m = 0;
  double z_m = 0;
  double yaw_rad = 0;
  std::uint64_t samples = 0;
};

/// A component of RmsFigures, under its key in summary.json and in limits.
struct RmsAxis {
  std::string_view key;
  std::string_view unit;
  double RmsFigures::*member;
};
inline constexpr std::array<RmsAxis, 4> kRmsAxes{{{"x_m", "m", &RmsFigures::x_m},
                                                  {"y_m", "m", &RmsFigures::y_m},
                                                  {"z_m", "m", &RmsFigures::z_m},
                                                  {"yaw_rad", "rad", &RmsFigures::yaw_rad}}};

}  // namespace cas::hils
