// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <chrono>
#include <cstdint>
#include <optional>

#include "base/time/clock.hpp"

namespace cas::casd {

/// How often a thread looks at its links while they are flooded.
///
/// Up to 50 packets a millisecond each packet is forwarded the moment it comes. What brings more
/// is looked at once in kPause: then several packets are read, routed and written with a system
/// call each time instead of one each, and who sends does not pay for waking this thread with every
/// packet. Network cards moderate their interrupts in the same way. A HIL link of 500 Hz, and a
/// lockstep run that waits for each answer, stay far below. kPause was chosen with the closed loop
/// of scripts/bench_router: with half of it a PTY still brings few packets at a look, a longer one
/// delays more and gains little.
class LookPace {
 public:
  static constexpr base::Duration kPause = std::chrono::microseconds(150);

  /// Without a flood for so long: it is over.
  static constexpr base::Duration kCalm = std::chrono::seconds(5);

  /// @param received  packets that have come so far, all links of the thread together
  /// @param idle      how long the thread has waited in poll so far; pauses do not count
  /// @return whether a span of 50 ms has ended, for which flood_lasts() answers anew
  bool looked(base::RunTime now, std::uint64_t received, base::Duration idle) {
    if (last_look_ == base::RunTime{}) last_flood_ = now;
    last_look_ = now;
    if (const auto moment = moment_.looked(now, received, idle)) {
      busy_ = moment->packets_ms > kBusyPackets;
    }
    const auto a_while = while_.looked(now, received, idle);
    if (!a_while) return false;
    flood_lasts_ = a_while->packets_ms > kBusyPackets ||
                   (a_while->packets_ms > kManyPackets && a_while->idle_share < kNoRest);
    // On a thread of its own the link may leave that thread idle, and yet flood: it stays there.
    if (a_while->packets_ms > kManyPackets) last_flood_ = now;
    return true;
  }

  /// Not before this: in the past, or not long ago, unless there is a flood.
  base::RunTime next_look() const { return busy_ ? last_look_ + kPause : last_look_; }
  bool busy() const { return busy_; }
  /// Judged by 50 ms: a burst is shorter, and a flood on a busy machine has gaps. A thread that is
  /// hardly idle is flooded by fewer packets.
  bool flood_lasts() const { return flood_lasts_; }
  bool flood_is_over(base::RunTime now) const { return now - last_flood_ >= kCalm; }
  /// A link has joined; its earlier packets do not count.
  void add_link(std::uint64_t received) {
    moment_.add_link(received);
    while_.add_link(received);
  }

 private:
  static constexpr double kBusyPackets = 50;  ///< a millisecond
  static constexpr double kManyPackets = 10;  ///< a millisecond, where the thread is hardly idle
  static constexpr double kNoRest = 0.1;      ///< share of idle time that is hardly any

  /// Packets and idle time of the span of time that has just ended; the next one begins there.
  class Span {
   public:
    struct Figures {
      double packets_ms;  ///< packets a millisecond
      double idle_share;  ///< 0 to 1
    };
    explicit Span(base::Duration length) : length_(length) {}

    /// @return figures of the span that has ended
    std::optional<Figures> looked(base::RunTime now, std::uint64_t received, base::Duration idle) {
      const base::Duration elapsed = now - begin_;
      if (elapsed < length_) return std::nullopt;
      // A link that was taken away takes its packets along.
      const std::uint64_t came = received > received_before_ ? received - received_before_ : 0;
      const Figures figures{static_cast<double>(came) / (base::to_seconds(elapsed) * 1e3),
                            base::to_seconds(idle - idle_before_) / base::to_seconds(elapsed)};
      begin_ = now;
      received_before_ = received;
      idle_before_ = idle;
      return figures;
    }
    void add_link(std::uint64_t received) { received_before_ += received; }

   private:
    base::Duration length_;
    base::RunTime begin_{};
    std::uint64_t received_before_ = 0;
    base::Duration idle_before_{};
  };

  Span moment_{std::chrono::milliseconds(1)};
  Span while_{std::chrono::milliseconds(50)};
  base::RunTime last_look_{};
  base::RunTime
      last_flood_{};  ///< end of the last span with many packets; at first, of the first look
  bool busy_ = false;
  bool flood_lasts_ = false;
};

}  // namespace cas::casd
