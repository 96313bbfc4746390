// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "mavlink/common/ping.hpp"
#include "mavlink/common/timesync.hpp"
#include "mavlink_gen/runtime/packet.hpp"
#include "mavlink_gen/services/time.hpp"

// The time protocols (https://mavlink.io/en/services/timesync.html and ping.html).
namespace cas::mav::services {

/// The answer to a TIMESYNC; nullopt if the message is itself an answer.
/// @param clock  of the answering node, from any zero
inline std::optional<mavlink::common::Timesync> answer(const mavlink::common::Timesync& request,
                                                       Source from, Duration clock) {
  if (request.tc1 != 0) return std::nullopt;
  mavlink::common::Timesync reply;
  reply.tc1 = clock.count();
  reply.ts1 = request.ts1;
  reply.target_system = from.system;
  reply.target_component = from.component;
  return reply;
}

/// The answer to a PING; nullopt where the message is an answer itself.
inline std::optional<mavlink::common::Ping> answer(const mavlink::common::Ping& request,
                                                   Source from) {
  if (request.target_system != 0 || request.target_component != 0) return std::nullopt;
  return mavlink::common::Ping{request.time_usec, request.seq, from.system, from.component};
}

/// Offset of another node's clock to ours, by TIMESYNC. The quickest of the last few answers
/// counts: its two ways took nearly the same time.
class ClockEstimate {
 public:
  /// The question to send, every second or so.
  mavlink::common::Timesync ask(Time now) const {
    mavlink::common::Timesync question;
    question.ts1 = now.time_since_epoch().count();
    return question;
  }

  /// @return whether it is an answer to a question of ours
  bool on_timesync(const mavlink::common::Timesync& message, Time now) {
    // The numbers are from the network: bounds first, so that no difference overflows.
    const Time asked{Duration(message.ts1)};
    const Duration theirs(message.tc1);
    if (message.tc1 == 0 || asked > now || asked < now - kLongest) return false;
    const Duration there_and_back = now - asked;
    const Duration between = (asked + there_and_back / 2).time_since_epoch();
    if (theirs > kFarthest || theirs < -kFarthest) return false;
    answers_[count_++ % answers_.size()] = {there_and_back, theirs - between};
    return true;
  }

  /// Their clock less ours; nullopt while no answer has come.
  std::optional<Duration> offset() const {
    const Answer* best = quickest();
    return best == nullptr ? std::nullopt : std::optional(best->offset);
  }
  /// Round trip of the answer behind offset().
  std::optional<Duration> round_trip() const {
    const Answer* best = quickest();
    return best == nullptr ? std::nullopt : std::optional(best->round_trip);
  }

 private:
  /// Later ones are no answers, but other nodes' numbers.
  static constexpr Duration kLongest = std::chrono::seconds(10);
  /// No clock shows as much, whether it counts from 1970 or from its start: 146 years.
  static constexpr Duration kFarthest = Duration::max() / 2;
  struct Answer {
    Duration round_trip{};
    Duration offset{};
  };

  const Answer* quickest() const {
    const Answer* best = nullptr;
    for (std::size_t i = 0; i < answers_.size() && i < count_; ++i) {
      if (best == nullptr || answers_[i].round_trip < best->round_trip) best = &answers_[i];
    }
    return best;
  }

  std::array<Answer, 8> answers_{};
  std::size_t count_ = 0;
};

}  // namespace cas::mav::services
