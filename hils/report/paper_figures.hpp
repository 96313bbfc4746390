// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <string_view>

namespace cas::hils {

/// A row of [HILS] Table 4: average rates at the receivers, Hz, as QGroundControl's meter showed
/// them.
struct PaperRates {
  std::string_view name;
  double sensor_hz;
  double sensor_error_pct;
  double gps_hz;
  double gps_error_pct;
  double controls_hz;
  double controls_error_pct;
};

/// A row of [HILS] Table 5: RMS errors of the hover at 2.5 m; the yaw angle is read as rad.
struct PaperRms {
  std::string_view name;
  double x_m;
  double y_m;
  double z_m;
  double yaw_rad;
};

inline constexpr std::array<PaperRates, 3> kPaperTable4{{
    {"SITL", 462.7284, 7.4543, 4.4901, 10.1972, 382.9965, 4.2509},
    {"TS", 352.8847, 29.4231, 3.6218, 27.5650, 279.4541, 30.1365},
    {"TCAS", 431.8999, 13.6200, 4.1525, 16.9509, 342.6261, 14.3435},
}};

inline constexpr std::array<PaperRms, 3> kPaperTable5{{
    {"SITL", 0.0068, 0.0050, 0.0449, 0.0342},
    {"TS", 0.0581, 0.0790, 0.2131, 0.0866},
    {"TCAS", 0.0196, 0.0179, 0.0996, 0.0429},
}};

}  // namespace cas::hils
