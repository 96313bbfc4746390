// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <fmt/format.h>

#include <cstdint>
#include <optional>
#include <string>

#include "libsim/core/run/sim_loop.hpp"

namespace cas::sim {

/// Reports during a run that the simulation does not keep up with the clock: between two looks it
/// ran slower than ordered (it falls behind), or more than 1 % of its steps began more than a step
/// late. Pure.
class PaceWatch {
 public:
  /// @param speed  ordered, simulated seconds per second
  explicit PaceWatch(double speed) : speed_(speed) {}

  /// @return a sentence if the loop did not keep up since the last look
  std::optional<std::string> look(const LoopFigures& now) {
    constexpr double kLeastFactor = 0.99;
    constexpr double kMostLate = 0.01;
    const LoopFigures before = last_;
    last_ = now;
    const double wall_s = now.wall_s - before.wall_s;
    // After a pause or a reset there is nothing to compare.
    if (now.paused || now.steps <= before.steps || wall_s <= 0) return std::nullopt;
    const double factor = base::to_seconds(now.time - before.time) / wall_s;
    const std::uint64_t steps = now.steps - before.steps;
    const std::uint64_t late =
        now.late_steps >= before.late_steps ? now.late_steps - before.late_steps : now.late_steps;
    const bool slow = factor < kLeastFactor * speed_;
    if (!slow && static_cast<double>(late) <= kMostLate * static_cast<double>(steps)) {
      return std::nullopt;
    }
    return fmt::format("{}: {:.2f} x real time, {} of {} steps late in the last {:.0f} s",
                       slow ? "falls behind" : "steps begin late", factor, late, steps, wall_s);
  }

 private:
  double speed_;
  LoopFigures last_{};
};

}  // namespace cas::sim
