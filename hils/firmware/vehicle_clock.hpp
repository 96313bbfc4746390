// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cstddef>
#include <deque>

#include "base/time/clock.hpp"

namespace cas::hils {

/// Maps the vehicle's clock to simulated time: both run alike, from different zeros. A reading of
/// the vehicle's clock is always a little old, so the smallest recent difference is the true one.
class VehicleClock {
 public:
  /// @param vehicle  its newest time when simulated time was asked for
  /// @param now  the answer
  void add(base::Duration vehicle, base::SimTime now) {
    differences_.push_back(now.time_since_epoch() - vehicle);
    if (differences_.size() > kLooks) differences_.pop_front();
  }
  bool empty() const { return differences_.empty(); }
  /// Simulated time at a moment of the vehicle's clock. Not when empty.
  base::SimTime to_sim(base::Duration vehicle) const {
    return base::SimTime(vehicle + *std::min_element(differences_.begin(), differences_.end()));
  }

 private:
  static constexpr std::size_t kLooks = 200;
  std::deque<base::Duration> differences_;
};

}  // namespace cas::hils
