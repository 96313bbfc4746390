// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace cas::hils {

/// One figure of the controller with the bound it is held to.
struct FlightFigure {
  std::string name;  ///< "hover, table1: true x"
  double value = 0;
  std::optional<double> bound;  ///< largest value that passes; nullopt: shown, not judged
  std::string unit;
  std::string note;  ///< source of the bound, or a value for comparison

  bool missed() const { return bound && !(value <= *bound); }
};

/// Exit code of flight_figures: kExitPassed, or kExitLimitsMissed if a bound is missed.
int exit_code(const std::vector<FlightFigure>& figures);

/// How many flights, with which seeds, on how many processors.
struct FlightBatch {
  int flights = 30;
  std::uint64_t first_seed = 1;
  int jobs = 1;
};

/// Hover at (0, 0, 2.5) m, 60 s a flight of which the last 40 count, pooled; beside the best
/// possible errors of the sensor set (tests/bench/estimation_bound/estimation_bound.hpp).
///
/// @param estimate_factor, tracking_factor  factors on the bound; 0: not judged
std::vector<FlightFigure> hover_figures(const std::string& sensors, double estimate_factor,
                                        double tracking_factor, const FlightBatch& batch);
/// The hover with the RTK set against figures in metres.
std::vector<FlightFigure> rtk_hover_figures(const FlightBatch& batch);
/// 1 m steps: time to stay within 5 %, and overshoot.
std::vector<FlightFigure> step_figures(const FlightBatch& batch);
/// A figure eight at 2 m/s.
std::vector<FlightFigure> figure_eight_figures(const FlightBatch& batch);
/// 8 m/s mean wind at 20 ft with light turbulence (Dryden's model, W20 15 knots).
std::vector<FlightFigure> wind_figures(const FlightBatch& batch);
/// One packet in ten lost each way; 10 ms more delay each way.
std::vector<FlightFigure> poor_line_figures(const FlightBatch& batch);
/// Flights of 60 s with Table 1 noise, mass +-20 %, wind up to 6 m/s with turbulence, any heading:
/// how many crashed or drifted away.
std::vector<FlightFigure> crash_figures(const FlightBatch& batch);

}  // namespace cas::hils
