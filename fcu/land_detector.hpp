// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace cas::fcu {

/// Finds out that the vehicle stands on the ground.
///
/// In the air, thrust well below hover makes the vehicle fall: low thrust without vertical motion
/// for half a second happens on the ground only.
class LandDetector {
 public:
  struct Input {
    double thrust_ratio = 1;  ///< thrust over hover thrust
    double vertical_speed_m_s = 0;
    double horizontal_speed_m_s = 0;
    double rate_rad_s = 0;    ///< norm of the body rates
    bool descending = false;  ///< the set-point wants down (or nothing)
  };

  void reset() { contact_s_ = 0; }
  /// @param dt  s @return true while standing on the ground
  bool update(const Input& in, double dt) {
    constexpr double kThrustRatio = 0.6;
    constexpr double kVerticalSpeed_m_s = 0.3;
    constexpr double kHorizontalSpeed_m_s = 1.0;
    constexpr double kRate_rad_s = 0.5;
    const bool contact =
        in.descending && in.thrust_ratio < kThrustRatio &&
        -kVerticalSpeed_m_s < in.vertical_speed_m_s && in.vertical_speed_m_s < kVerticalSpeed_m_s &&
        in.horizontal_speed_m_s < kHorizontalSpeed_m_s && in.rate_rad_s < kRate_rad_s;
    contact_s_ = contact ? contact_s_ + dt : 0;
    return contact_s_ > kContactTime_s;
  }

 private:
  static constexpr double kContactTime_s = 0.5;
  double contact_s_ = 0;
};

}  // namespace cas::fcu
