// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "hils/measure/measurement.hpp"
#include "hils/measure/tracking.hpp"

namespace cas::hils {

/// The measured step as the vehicle flew it; nullptr: the flight did not come through it.
const Stage* measured_stage(const std::vector<Stage>& stages);

/// Works out the motion in the measured step. A hold on a circle is measured about the circle. Any
/// other hold of stock firmware is measured about its mean,
/// because where a stock estimator's origin lies is not known so well, and its estimate against the
/// truth; all else against the reference.
/// @throws base::ConfigError when the flight log cannot be read
void measure_motion(const RunRecord& record, std::span<const PoseSample> truth,
                    Measurement& figures);

/// Reference of Measurement::rms: "the reference", "its mean" or "its circle".
std::string_view measured_about(const Measurement& figures);

/// How far an estimate was from the truth in the measured step; nullopt without one of the two.
/// Places and height count from the last second before takeoff, because a stock estimator's origin
/// lies a little off; the heading counts as it is.
std::optional<RmsFigures> estimate_error(const std::vector<Stage>& stages,
                                         std::span<const PoseSample> truth,
                                         std::span<const PoseSample> estimate);

/// Window in which the machine is judged by the stream of stock firmware in HITL: the measured
/// step, or all steps of a flight that failed or of which too little is left; at most until a fault
/// of the bench begins or the firmware falls silent, because what is missing then is not the
/// machine's. nullopt: less than 1 s.
std::optional<StreamWindow> machine_window(const RunRecord& record,
                                           const std::vector<Incident>& incidents);

}  // namespace cas::hils
