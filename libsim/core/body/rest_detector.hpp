// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>

#include "libsim/api/world.hpp"

namespace cas::sim {

/// Detects when a body in contact has come to rest, and when its loads have changed enough to call
/// the contact solver again. In between it is held still: it cannot creep and costs nothing.
class RestDetector {
 public:
  /// @param weight_n, radius_m  of the body: scales of a significant change
  RestDetector(double weight_n, double radius_m)
      : force_change_(kChange * weight_n), torque_change_(kChange * weight_n * radius_m) {}

  /// Books one contact step of `dt` s that ended in `state` under `wrench`.
  void update(const BodyState& state, const Wrench& wrench, double dt) {
    const bool quiet = state.v_WB.squaredNorm() < kSpeed * kSpeed &&
                       state.w_WB_B.squaredNorm() < kRate * kRate && same(wrench);
    if (quiet) {
      quiet_s_ += dt;
    } else {
      quiet_s_ = 0;
      reference_ = wrench;
    }
  }
  bool at_rest() const { return quiet_s_ >= kQuiet; }
  /// True when `wrench` is near enough to the one under which the body came to rest.
  bool same(const Wrench& wrench) const {
    return (wrench.force_B - reference_.force_B).squaredNorm() <= force_change_ * force_change_ &&
           (wrench.torque_B - reference_.torque_B).squaredNorm() <= torque_change_ * torque_change_;
  }
  void wake() { quiet_s_ = 0; }
  /// One step short of rest, because a touching body still moves.
  void almost() { quiet_s_ = std::min(quiet_s_, 0.99 * kQuiet); }

 private:
  static constexpr double kSpeed = 1e-4;   // m/s
  static constexpr double kRate = 1e-3;    // rad/s
  static constexpr double kQuiet = 0.1;    // s
  static constexpr double kChange = 1e-3;  // of the weight: a tenth of what friction could notice

  double force_change_;
  double torque_change_;
  Wrench reference_;
  double quiet_s_ = 0;
};

}  // namespace cas::sim
