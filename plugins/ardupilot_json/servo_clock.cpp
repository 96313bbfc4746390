// SPDX-License-Identifier: BSD-3-Clause
#include "plugins/ardupilot_json/servo_clock.hpp"

#include <algorithm>

namespace cas::sim {
namespace {

/// A timestamp that jumps by 0.1 s or more makes SITL skip its own time advance.
constexpr base::Duration kLongestPeriod = std::chrono::milliseconds(99);
/// Slowest rate that fits.
constexpr std::uint16_t kSlowest_hz = 11;

}  // namespace

void ServoClock::begin_period(const ServoPacket& packet, base::SimTime now) {
  const auto rate = std::max(packet.frame_rate_hz, kSlowest_hz);
  const base::Duration period =
      std::min(base::Duration(std::chrono::seconds(1)) / static_cast<base::Duration::rep>(rate),
               kLongestPeriod);
  // On a grid, so that a period which is no multiple of the step is right on average.
  const bool is_on_grid = started_ && now - period_end_ <= step_ && period_end_ - now <= step_;
  period_end_ = (is_on_grid ? period_end_ : now) + period;
  started_ = true;
  pending_ = true;
  frame_count_ = packet.frame_count;
  ++counts_.packets;
}

ServoClock::Kind ServoClock::on_packet(const ServoPacket& packet, base::SimTime now) {
  if (!started_) {
    begin_period(packet, now);
    return Kind::kNew;
  }
  if (packet.frame_count == frame_count_) {
    ++counts_.repeated;
    return pending_ ? Kind::kPending : Kind::kRepeated;
  }
  const bool is_restart = packet.frame_count < frame_count_;
  if (is_restart) {
    ++counts_.restarts;
  } else {
    counts_.skipped += packet.frame_count - frame_count_ - 1;
  }
  begin_period(packet, now);
  return is_restart ? Kind::kRestart : Kind::kNew;
}

}  // namespace cas::sim
