// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>

namespace cas::fcu {

/// Tells a receiver that repeats its last fix from one that measures.
///
/// A fix whose stamp stands still is a repetition. So is one whose position and velocity repeat to
/// the digit, where that cannot be: the receiver showed noise while it stood still, or the vehicle
/// moves. A receiver without noise (some simulators) may repeat at rest.
class RepeatedFixes {
 public:
  /// Latitude, longitude, altitude and velocity as they came, in units of the message.
  using Digits = std::array<std::int32_t, 6>;
  struct Fix {
    std::uint64_t time_usec = 0;  ///< 0: without a stamp
    Digits digits{};
    bool at_rest = false;  ///< the vehicle stands still, by the IMU
    bool moving = false;   ///< it moves, by the estimate or by the fix
  };

  /// @return whether the fix is a measurement
  bool accept(const Fix& fix) {
    const bool same_time = seen_ && fix.time_usec != 0 && fix.time_usec == last_.time_usec;
    const bool same_digits = seen_ && fix.digits == last_.digits;
    seen_ = true;
    last_ = fix;
    repeats_ = same_digits ? repeats_ + 1 : 0;
    fresh_at_rest_ = fix.at_rest && !same_digits ? fresh_at_rest_ + 1 : 0;
    noisy_ = noisy_ || fresh_at_rest_ >= kFreshAtRest;
    const bool frozen = repeats_ >= kChance && (noisy_ || fix.moving);
    left_out_ = same_time || frozen ? left_out_ + 1 : 0;
    return left_out_ == 0;
  }

  /// Nothing new came with the last fixes.
  bool frozen() const { return left_out_ >= kTold; }

 private:
  static constexpr int kFreshAtRest = 10;  // in a row: the receiver has noise
  static constexpr int kChance = 2;        // one repetition may be chance
  static constexpr int kTold = 5;

  Fix last_;
  bool seen_ = false;
  bool noisy_ = false;
  int fresh_at_rest_ = 0;
  int repeats_ = 0;
  int left_out_ = 0;
};

}  // namespace cas::fcu
