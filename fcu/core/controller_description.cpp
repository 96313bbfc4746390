// SPDX-License-Identifier: BSD-3-Clause
#include "fcu/core/controller_description.hpp"

#include <fmt/format.h>

#include <utility>

#include "fcu/control/loop_design.hpp"
#include "fcu/estimation/sensor_figures.hpp"
#include "fcu/params/param_table.hpp"

namespace cas::fcu {
namespace {

std::string describe_loops(const base::Vehicle& vehicle, const ControlParams& params,
                           double delay_s) {
  constexpr double kLeastPhase_deg = 30;
  constexpr double kLeastGain = 2;
  constexpr std::pair<const char*, const char*> kAxes[] = {
      {"roll", "MC_ROLLRATE_K"}, {"pitch", "MC_PITCHRATE_K"}, {"yaw", "MC_YAWRATE_K"}};
  std::string text = fmt::format(
      "rate loops         motors lag by {:.0f} ms, {:.1f} ms from the gyro to the motors\n"
      "                   crossover    phase margin  gain margin\n",
      1e3 * motor_lag_s(vehicle), 1e3 * delay_s);
  const auto loops = rate_loops(vehicle, params, delay_s);
  for (std::size_t axis = 0; axis < loops.size(); ++axis) {
    const auto& [name, parameter] = kAxes[axis];
    const LoopMargins own = margins(loops[axis]);
    const double phase_deg = own.phase_rad / base::kRadPerDeg;
    text += fmt::format("  {:<16} {:6.1f} rad/s  {:8.1f} deg  {:9.2f}\n", name, own.crossover_rad_s,
                        phase_deg, own.gain);
    if (phase_deg >= kLeastPhase_deg && own.gain >= kLeastGain) continue;
    text += fmt::format(
        "warning: {}: less than {:.0f} degrees or a factor of {:.0f} are left; lower {}\n", name,
        kLeastPhase_deg, kLeastGain, parameter);
  }
  return text;
}

}  // namespace

double loop_delay_s(const FcuConfig& config) {
  constexpr double kBits = 10 * (76 + 54);  // HIL_SENSOR and HIL_CONTROLS, 10 bits a byte
  constexpr double kSimulatorAndHops_s = 0.0011;
  const LineConfig& line = config.line;
  const double on_the_line_s = line.baud > 0 ? kBits / line.baud : 0;
  const double each_way_s =
      base::to_seconds(line.extra_delay) + base::to_seconds(line.jitter + line.batch) / 2;
  return kSimulatorAndHops_s + 1 / config.control_rate_hz + on_the_line_s + 2 * each_way_s;
}

std::string describe_controller(const FcuConfig& config) {
  ParamStore params(config.vehicle, sensor_figures(config.sensors).params);
  for (const auto& [name, value] : config.params) params.set(name, value);
  return describe_loops(config.vehicle, read_settings(params).control, loop_delay_s(config));
}

}  // namespace cas::fcu
