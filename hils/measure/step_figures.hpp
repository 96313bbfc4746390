// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "hils/flight/flight_plan.hpp"
#include "hils/measure/plugin_figure.hpp"
#include "hils/measure/tracking.hpp"

/// How single steps were flown, by the truth. Places of a plan count from the first sample.
namespace cas::hils {

/// The point of the stage's circle that is nearest to the vehicle at each moment, with the
/// vehicle's own heading. Both outlive the result.
ReferenceAt circle_reference(const Stage& stage, std::span<const PoseSample> truth);

/// Mean distance from the middle of the stage's circle against its radius, without a sign.
/// @param flown  samples of the stage, not empty @param start  first sample of the truth
double radius_error_pct(const Stage& stage, std::span<const PoseSample> flown, const Pose& start);

/// nullopt where no sample has an airspeed.
std::optional<double> least_airspeed_m_s(std::span<const PoseSample> samples);

/// The most that the height differed from that at the begin of a transition, until the vehicle said
/// that it was over; of all of the flight. nullopt: it had none.
std::optional<double> transition_height_m(const std::vector<Stage>& stages,
                                          std::span<const PoseSample> truth);

/// Horizontal distance between where the last `land` was begun and where it ended; of a vehicle on
/// its wing between the first sample and that, for it lands where it took off. nullopt: there was
/// none, or the vehicle neither hung still then nor flew on its wing.
std::optional<double> landing_error_m(const std::vector<Stage>& stages,
                                      std::span<const PoseSample> truth);

/// Horizontal distance from its beacon, at the end of the run, as plugin landing_target reports it;
/// nullopt: the vehicle does not have it.
std::optional<double> beacon_error_m(const std::vector<PluginFigure>& figures);

/// Horizontal distance between where the last step `sticks` was begun and where it ended; nullopt:
/// there was none.
std::optional<double> sticks_way_m(const std::vector<Stage>& stages,
                                   std::span<const PoseSample> truth);

}  // namespace cas::hils
