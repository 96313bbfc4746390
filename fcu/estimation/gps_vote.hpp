// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <optional>

#include "base/time/clock.hpp"
#include "fcu/estimation/imu_vote.hpp"
#include "fcu/estimation/repeated_fixes.hpp"

namespace cas::fcu {

/// Chooses one of two receivers.
///
/// The one in use stays in use until the other has fixes and it has none (for three of its periods,
/// at least 0.6 s), its fixes repeat, or two fixes in a row are far from the estimate and those of
/// the other at most half as far. A slow drift takes the estimate with it and is not noticed.
class GpsVote {
 public:
  static constexpr int kMost = 2;

  /// A fix as the vote sees it.
  struct Fix {
    base::SimTime heard;        ///< when it came
    bool has_fix = false;       ///< three-dimensional, and a number
    RepeatedFixes::Fix digits;  ///< as it came
    /// From the estimate at its time, in limits: above 1 it is far. nullopt: there is no estimate.
    std::optional<double> off;
  };

  /// Notes a fix and judges the receivers. @param at  the receiver, from 0
  void on_fix(int at, const Fix& fix);
  /// Whether there is more than the first.
  bool several() const { return several_; }
  /// The change that on_fix() has just made, once.
  std::optional<VoteSwitch> take_switch();
  /// The one in use, from 0.
  int used() const { return used_; }

 private:
  struct Receiver {
    RepeatedFixes repeated;
    std::optional<base::SimTime> last;  ///< fix that was a measurement
    double period_s = 0;
    double off = 0;
    int far = 0;  ///< in a row
  };

  VoteCause judge(const Receiver& own, const Receiver& other, base::SimTime now) const;

  std::array<Receiver, kMost> receivers_{};
  std::optional<VoteSwitch> switch_;
  int used_ = 0;
  bool several_ = false;
};

}  // namespace cas::fcu
