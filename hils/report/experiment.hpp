// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>

#include "hils/measure/judgement.hpp"
#include "hils/measure/measurement.hpp"

namespace cas::hils {

/// Kind of a flight, by its steps: "hover", "step responses", "figure eight", "circle" or "flight
/// from place to place"; "with faults" behind it where there were any.
std::string experiment_of(const Measurement& figures);

/// The measured part: "hover", "hold" (after a flight to other places), "step response 'after'",
/// "circle 'name'"; "whole flight" where the measured step was not completed.
std::string measured_part(const Measurement& figures);

/// Who is measured, in tables: the stock autopilot, "PX4", or our architecture, "TCAS".
std::string controller_name(const Measurement& figures);

/// Whether the vehicle was to stay where it was while it was measured, as in Table 5 of [HILS].
bool measures_station_keeping(const Measurement& figures);

/// Architecture and clock of a run: "TCAS", "TCAS on the virtual clock", "TCAS in lockstep".
std::string how_it_ran(const Measurement& figures);

/// Why a run without a verdict did not fly to its end: not judged, but often the first thing to
/// know. nullopt: it did, or the verdict says so.
std::optional<std::string> unjudged_failure(const Measurement& figures, const Verdict& verdict);

/// Heading of a report: "hover, TCAS", or "gain_tuning: step responses, TCAS".
std::string report_title(const Measurement& figures);

}  // namespace cas::hils
