// SPDX-License-Identifier: BSD-3-Clause
#include "fcu/core/controller_description.hpp"

#include <algorithm>

#include "fcu/control/loop_design.hpp"
#include "fcu/control/loop_table.hpp"
#include "fcu/estimation/sensor_figures.hpp"
#include "fcu/params/param_table.hpp"

namespace cas::fcu {
namespace {

/// Without the delays that the line's model adds to its bytes.
double clocked_delay_s(const FcuConfig& config) {
  constexpr double kBits = 10 * (76 + 54);  // HIL_SENSOR and HIL_CONTROLS, 10 bits a byte
  constexpr double kSimulatorAndHops_s = 0.0011;
  const double on_the_line_s = config.line.baud > 0 ? kBits / config.line.baud : 0;
  return kSimulatorAndHops_s + 1 / config.control_rate_hz + on_the_line_s;
}

}  // namespace

double loop_delay_s(const FcuConfig& config) {
  const LineConfig& line = config.line;
  const double each_way_s =
      base::to_seconds(line.extra_delay) + base::to_seconds(line.jitter + line.batch) / 2;
  return clocked_delay_s(config) + 2 * each_way_s;
}

double design_delay_s(const FcuConfig& config) {
  return std::max(kUsualDelay_s, clocked_delay_s(config));
}

std::string describe_controller(const FcuConfig& config) {
  ParamStore params(config.vehicle, sensor_figures(config.sensors).params, design_delay_s(config));
  for (const auto& [name, value] : config.params) params.set(name, value);
  return loop_table(
      rate_loops(config.vehicle, read_settings(params).control, loop_delay_s(config)));
}

}  // namespace cas::fcu
