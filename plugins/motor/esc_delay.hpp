// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <vector>

#include "base/config/vehicle.hpp"
#include "base/time/clock.hpp"
#include "plugins/common/delay_line.hpp"

namespace cas::sim {

/// The dead time of speed controllers: each rotor's command acts that much later, at the first step
/// at or after it.
class EscDelay {
 public:
  EscDelay() = default;
  EscDelay(const base::Vehicle& vehicle, base::Duration step) : held_(vehicle.rotor_count()) {
    constexpr std::size_t kPerStep = 2;  // commands
    for (const base::Rotor& rotor : vehicle.rotors) {
      const base::Duration delay = base::from_seconds(rotor.params.esc_dead_time_s);
      longest_ = std::max(longest_, delay);
      lines_.emplace_back(delay, kPerStep * static_cast<std::size_t>(delay / step + 2));
    }
    clear();
  }

  /// Whether any rotor has a dead time.
  bool is_used() const { return longest_ > base::Duration::zero(); }
  void push(base::SimTime now, const base::RotorVector& asked) {
    for (std::size_t i = 0; i < lines_.size(); ++i) {
      lines_[i].push(now, asked[static_cast<Eigen::Index>(i)]);
    }
  }
  /// Targets that the speed controllers act on now.
  const base::RotorVector& held(base::SimTime now) {
    for (std::size_t i = 0; i < lines_.size(); ++i) {
      while (const auto due = lines_[i].pop(now)) held_[static_cast<Eigen::Index>(i)] = *due;
    }
    return held_;
  }
  void clear() {
    held_.setZero();
    for (auto& line : lines_) line.clear();
  }

 private:
  base::Duration longest_{};
  std::vector<DelayLine<double>> lines_;
  base::RotorVector held_;
};

}  // namespace cas::sim
