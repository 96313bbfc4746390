// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace cas::fcu {

/// Finds out that the vehicle stands on the ground, in two steps.
///
/// Contact: wants down, does not go down, and thrust is already low. Then the thrust is taken away.
/// Landed: with a third of the hover thrust and less nothing moves. In the air either would make
/// the vehicle fall, which ends the suspicion.
class LandDetector {
 public:
  /// How sure it is.
  enum class Stage { kAir, kContact, kLanded };

  /// What it looks at in one control step.
  struct Input {
    double thrust_ratio = 1;        ///< thrust over hover thrust
    double vertical_speed_m_s = 0;  ///< down, of the estimate
    double horizontal_speed_m_s = 0;
    bool descending = false;  ///< the setpoint wants down (or nothing)
  };

  void reset() { *this = LandDetector{}; }

  /// @param dt  s
  Stage update(const Input& in, double dt) {
    constexpr double kVerticalSpeed_m_s = 0.3;
    constexpr double kHorizontalSpeed_m_s = 1.0;
    const bool still = in.descending && -kVerticalSpeed_m_s < in.vertical_speed_m_s &&
                       in.vertical_speed_m_s < kVerticalSpeed_m_s &&
                       in.horizontal_speed_m_s < kHorizontalSpeed_m_s;
    const bool suspected =
        still && (contact_s_ > kContactTime_s || in.thrust_ratio < kContactThrust);
    contact_s_ = suspected ? contact_s_ + dt : 0;
    landed_s_ = suspected && in.thrust_ratio < kLandedThrust ? landed_s_ + dt : 0;
    if (landed_s_ > kLandedTime_s) return Stage::kLanded;
    return contact_s_ > kContactTime_s ? Stage::kContact : Stage::kAir;
  }

 private:
  static constexpr double kContactThrust = 0.75;
  static constexpr double kContactTime_s = 0.25;
  static constexpr double kLandedThrust = 0.35;
  static constexpr double kLandedTime_s = 0.3;
  double contact_s_ = 0;
  double landed_s_ = 0;
};

}  // namespace cas::fcu
