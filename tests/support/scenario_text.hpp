// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "tests/support/paths.hpp"

namespace cas::test {

/// The quadrotor of [HILS] at the end of its line: keys of a scenario.
inline std::string paper_quadrotor() {
  return "vehicle: " + std::string(source_dir()) +
         "/config/vehicles/iris_paper.yaml\nline: {preset: baud_921600}\n";
}

/// A scenario of the shipped rates above the usual home.
/// @param keys  further lines, such as paper_quadrotor()
/// @param steps  a flow list: "[arm, takeoff: {altitude_m: 2}, land]"
inline std::string scenario_text(const std::string& keys, const std::string& steps) {
  return "schema: 1\nname: hop\ndescription: A short flight\n"
         "home: {lat_deg: 47.397742, lon_deg: 8.545594, alt_m: 488.0}\ndecimal_year: 2026.5\n"
         "seed: 1\nrates: {sensor_hz: 500, gps_hz: 5, controls_hz: 400}\n" +
         keys + "steps: " + steps + "\n";
}

}  // namespace cas::test
