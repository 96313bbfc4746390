// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <span>

#include "casd/topology/line_budget.hpp"

namespace cas::hils {

/// A HIL run's demand on a controller's line.
struct LineDemand {
  double sensor_hz = 500;  ///< HIL_SENSOR, to the controller
  double gps_hz = 5;       ///< HIL_GPS, to the controller
  double controls_hz = 400;
  bool by_rotor = false;  ///< answers are HIL_ACTUATOR_CONTROLS, as stock firmware's
};

/// Bytes of one packet of the stream, at its longest.
std::size_t sensor_bytes();
std::size_t gps_bytes();
std::size_t controls_bytes(const LineDemand& demand);

/// The same demand at another rate of HIL_SENSOR: a controller answers each one once at most.
LineDemand at_sensor_rate(LineDemand demand, double sensor_hz);

/// Rates of HIL_SENSOR that are tried where the one that is wanted does not fit, highest first.
std::span<const double> usual_sensor_rates();

/// Budget of a line that carries `bytes_s` to the controller: 98 % of it may be used, as casd does.
casd::LineBudget budget_to(const LineDemand& demand, double bytes_s);
/// The same from the controller. @param background_bytes_s  its other messages
casd::LineBudget budget_from(const LineDemand& demand, double background_bytes_s, double bytes_s);

}  // namespace cas::hils
