// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "hils/measure/measurement.hpp"

namespace cas::hils {

/// Kind of a flight, by its steps: "hover", "step responses", "figure eight", "circle" or "flight
/// from place to place"; "with faults" behind it where there were any.
std::string experiment_of(const Measurement& figures);

/// The measured part: "hover", "hold" (after a flight to other places), "step response 'after'",
/// "circle 'name'"; "whole flight" where the measured step was not reached.
std::string measured_part(const Measurement& figures);

/// Whether the vehicle was to stay where it was while it was measured, as in Table 5 of [HILS].
bool measures_station_keeping(const Measurement& figures);

/// Heading of a report: "hover, TCAS", or "gain_tuning: step responses, TCAS".
std::string report_title(const Measurement& figures);

}  // namespace cas::hils
