// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "base/config/config.hpp"

namespace cas::hils {

/// A serial line whose delay grows in steps until the vehicle falls: one flight measures the delay
/// margin of the whole loop. Each step is a fault `line: {extra_delay_us}` that lasts `every_s`.
struct DelayRamp {
  double from_s = 0;   ///< simulated time of the first step
  double every_s = 2;  ///< how long each delay lasts
  double step_us = 0;  ///< each way
  double most_us = 0;  ///< of the last step

  /// Reads `{from_s, every_s, step_us, most_us}`. @throws base::ConfigError
  static DelayRamp parse(const base::ConfigNode& node);
  /// The list `faults` of the scenario, as YAML.
  std::string faults() const;
  /// The largest delay that a flight has borne for `every_s`, each way.
  /// @param end_s  simulated time of the first incident, or of the flight's end
  double margin_us(double end_s) const;

 private:
  int steps() const;
};

}  // namespace cas::hils
