// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "base/config/config.hpp"
#include "hils/flight/flight_step.hpp"

namespace cas::hils {

/// Most that the response to one step of a flight may show.
struct ResponseLimits {
  std::optional<double> rise_s;
  std::optional<double> overshoot_pct;
  std::optional<double> settling_s;
};

/// Most that a run may miss by; what a scenario leaves out is not judged.
struct Limits {
  std::optional<std::uint64_t> lost;           ///< packets of each HIL message in the window
  std::optional<double> rate_error_pct;        ///< received rate against nominal, either way
  std::optional<double> delivered_pct;         ///< least share of each HIL message that arrives
  std::optional<double> latency_p99_us;        ///< sensor to control
  std::map<std::string, double> rms;           ///< x_m, y_m, z_m, yaw_rad: truth against reference
  std::map<std::string, double> rms_estimate;  ///< the same axes: estimate against reference
  std::map<std::string, ResponseLimits> responses;  ///< by the name of the step
};

/// Reads the block `limits`. @throws base::ConfigError
///
/// @param steps  the flight, whose steps `responses` names
Limits parse_limits(const base::ConfigNode& node, const std::vector<FlightStep>& steps);

/// Those of one vehicle of several: without responses to steps that others fly.
Limits limits_for(std::size_t vehicle, Limits limits, const std::vector<FlightStep>& steps);

}  // namespace cas::hils
