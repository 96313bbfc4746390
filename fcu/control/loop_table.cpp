// SPDX-License-Identifier: BSD-3-Clause
#include "fcu/control/loop_table.hpp"

#include <fmt/format.h>

#include <cmath>
#include <utility>

namespace cas::fcu {

std::string loop_table(const std::array<RateLoop, 3>& loops) {
  constexpr double kLeastPhase_deg = 30;
  constexpr double kLeastGain_db = 6;
  constexpr std::pair<const char*, const char*> kAxes[] = {
      {"roll", "MC_ROLLRATE_K"}, {"pitch", "MC_PITCHRATE_K"}, {"yaw", "MC_YAWRATE_K"}};
  std::string text = fmt::format(
      "rate loops         motors lag by {:.0f} ms, {:.1f} ms from the gyro to the motors\n"
      "                   crossover    phase margin  gain margin\n",
      1e3 * loops[0].lag_s, 1e3 * loops[0].delay_s);
  for (std::size_t axis = 0; axis < loops.size(); ++axis) {
    const auto& [name, parameter] = kAxes[axis];
    if (loops[axis].gain_rad_s <= 0) {
      text += fmt::format("  {:<16} not controlled\n", name);
      continue;
    }
    const LoopMargins own = margins(loops[axis]);
    const double phase_deg = own.phase_rad / base::kRadPerDeg;
    const double gain_db = 20 * std::log10(own.gain);
    text += fmt::format("  {:<16} {:6.1f} rad/s  {:8.1f} deg  {:8.1f} dB\n", name,
                        own.crossover_rad_s, phase_deg, gain_db);
    if (phase_deg >= kLeastPhase_deg && gain_db >= kLeastGain_db) continue;
    text += fmt::format("warning: {}: less than {:.0f} degrees or {:.0f} dB are left; lower {}\n",
                        name, kLeastPhase_deg, kLeastGain_db, parameter);
  }
  return text;
}

}  // namespace cas::fcu
