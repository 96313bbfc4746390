// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <chrono>
#include <cstddef>

#include "base/time/clock.hpp"

namespace cas::casd {

/// Predicts when a line of limited rate has sent its bytes, so that no more is handed over than it
/// carries: packets wait in our queue, where they can be reordered, replaced or dropped, and not in
/// the kernel's.
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
  /// 98 % of a serial line's rate, bytes/s.
  static double rate_of(unsigned baud) { return kLineShare * baud / 10.0; }

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
  /// The driver still holds so many bytes: the line is busy at least until they are sent.
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

/// The look at the line before a paced write ([HILS] Sect. 3.3): how many bytes the driver has not
/// yet put on it. A line slower than its rate, or held by flow control, shows here before anything
/// is lost.
///
/// Some drivers report a wrong number. A driver whose number stays above zero without a change for
/// longer than any line without flow control can need is ignored from then on.
class LineCheck {
 public:
  static constexpr base::Duration kPatience = std::chrono::seconds(2);

  /// @param may_stand_still  flow control: the other side may hold the line as long as it likes
  explicit LineCheck(bool may_stand_still = false) : may_stand_still_(may_stand_still) {}

  /// @return the bytes to wait for: `unsent`, or 0 from a driver that is not believed
  std::size_t believed(std::size_t unsent, base::RunTime now) {
    if (unsent == 0 || unsent != last_) since_ = now;
    last_ = unsent;
    if (!may_stand_still_ && now - since_ > kPatience) trusted_ = false;
    return trusted_ ? unsent : 0;
  }
  /// Something was written: a figure that does not change may be of new bytes.
  void wrote(base::RunTime now) { since_ = now; }
  /// A fresh line.
  void reset() { *this = LineCheck(may_stand_still_); }

 private:
  bool may_stand_still_;
  bool trusted_ = true;
  std::size_t last_ = 0;
  base::RunTime since_{};
};

/// When tcdrain(3) on a UART lets its caller go on (`threads: blocking`). Linux is woken when its
/// own buffer is empty, that is with one FIFO of bytes still to go, and from then on looks whether
/// the last bit is out: between two looks it sleeps for the rest of the clock tick and a whole one
/// (serial core, uart_wait_until_sent; kernels 4.8 to 6.12 sleep a tick longer still).
class LineDrain {
 public:
  static constexpr std::size_t kFifoBytes = 16;  ///< of a 16550
  /// The fastest tick that Linux is built with, CONFIG_HZ=1000; Debian's has 4 ms.
  static constexpr base::Duration kDefaultTick = std::chrono::milliseconds(1);
  /// Ten times as fast as any; between two looks at the line some time has to pass.
  static constexpr base::Duration kLeastTick = std::chrono::microseconds(100);

  /// @param tick  of the kernel's clock; 0: woken the moment the last bit is out
  explicit LineDrain(base::Duration tick = kDefaultTick) : tick_(tick) {}

  /// @param written    when the packet was handed over
  /// @param sent       when its last bit is out
  /// @param fifo_time  that the line takes for kFifoBytes
  base::RunTime done(base::RunTime written, base::RunTime sent, base::Duration fifo_time) const {
    if (tick_ <= base::Duration{}) return std::max(written, sent);
    base::RunTime look = std::max(written, sent - fifo_time);
    while (look < sent) look = base::RunTime{(look.time_since_epoch() / tick_ + 2) * tick_};
    return look;
  }

 private:
  base::Duration tick_;
};

}  // namespace cas::casd
