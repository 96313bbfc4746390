// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <chrono>
#include <cstddef>

#include "base/time/clock.hpp"

namespace cas::casd {

/// Knows when a line of limited rate is through with what it was given, so that no more is handed
/// over than it carries: what waits can then still be chosen, replaced or dropped in our queue
/// instead of ageing in the kernel's.
///
/// A serial line carries baud / 10 bytes a second (start and stop bit); it is paced at 98 % of
/// that, so that a difference between two clocks never accumulates.
class LinePacer {
 public:
  static constexpr double kLineShare = 0.98;
  /// How far the line may be given bytes ahead of time: covers the timer's jitter.
  static constexpr base::Duration kSlack = std::chrono::microseconds(500);

  /// No limit.
  LinePacer() = default;
  /// @param bytes_per_s  0: no limit
  explicit LinePacer(double bytes_per_s, base::Duration slack = kSlack)
      : bytes_per_s_(bytes_per_s), slack_(slack) {}
  /// 98 % of a serial line's rate.
  static LinePacer for_baud(unsigned baud, base::Duration slack = kSlack) {
    return LinePacer(kLineShare * baud / 10.0, slack);
  }

  /// Holds the line for this long after each sensor packet: a receiver that stamps sensors on
  /// arrival never gets two of them in a burst.
  void set_sensor_gap(base::Duration gap) { sensor_gap_ = gap; }

  bool limited() const { return bytes_per_s_ > 0 || sensor_gap_ > base::Duration{}; }
  /// True when the next packet may be handed over.
  bool ready(base::RunTime now) const {
    return !limited() || (busy_until_ - now <= slack_ && held_until_ <= now);
  }
  /// The moment from which `ready` holds.
  base::RunTime ready_at() const { return std::max(busy_until_ - slack_, held_until_); }
  /// When the last byte of a packet that is handed over now would be on the other side.
  base::RunTime arrival(std::size_t bytes, base::RunTime now) const {
    return std::max({busy_until_, held_until_, now}) + time_for(bytes);
  }
  /// The line was given so many bytes.
  void sent(std::size_t bytes, base::RunTime now) {
    if (bytes_per_s_ > 0) busy_until_ = std::max(busy_until_, now) + time_for(bytes);
  }
  /// The line was given a sensor packet.
  void sent_sensor(base::RunTime now) { held_until_ = now + sensor_gap_; }
  /// The driver still holds so many bytes: the line is busy at least until they are through.
  void holds(std::size_t bytes, base::RunTime now) {
    if (bytes_per_s_ > 0) busy_until_ = std::max(busy_until_, now + time_for(bytes));
  }
  /// Time the line takes for so many bytes.
  base::Duration time_for(std::size_t bytes) const {
    return bytes_per_s_ > 0 ? base::from_seconds(static_cast<double>(bytes) / bytes_per_s_)
                            : base::Duration{};
  }
  /// A fresh line: nothing on its way.
  void reset() { busy_until_ = held_until_ = base::RunTime{}; }

 private:
  double bytes_per_s_ = 0;
  base::Duration slack_ = kSlack;
  base::Duration sensor_gap_{};
  base::RunTime busy_until_{};
  base::RunTime held_until_{};  ///< by the sensor gap
};

}  // namespace cas::casd
