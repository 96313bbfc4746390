// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "hils/flight/flight_plan.hpp"
#include "hils/measure/tracking.hpp"

namespace cas::hils {

/// How a quantity followed a step of its reference.
struct StepResponse {
  std::string name{};
  double size = 0;
  std::optional<double> rise_s{};      ///< from 10 % to 90 % of the step
  double overshoot_pct = 0;            ///< most beyond the new value, of the step's size
  std::optional<double> settling_s{};  ///< from when on it stays within 5 % of the size
  double integrated_error = 0;         ///< integral of the absolute error, unit times s
};

/// A sample of the quantity.
struct ResponseSample {
  double time_s = 0;
  double value = 0;
};

/// @param samples  in order; those before `step_s` are left out
/// @param step_s   moment of the step
StepResponse respond(std::span<const ResponseSample> samples, double step_s, double from,
                     double to);

/// The responses of the true northward motion to each `trajectory: {shape: step}` of a flight,
/// under the names of the steps.
std::vector<StepResponse> step_responses(const std::vector<Stage>& stages,
                                         std::span<const PoseSample> truth);

}  // namespace cas::hils
