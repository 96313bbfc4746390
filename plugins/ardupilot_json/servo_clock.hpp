// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#include "base/time/clock.hpp"
#include "plugins/ardupilot_json/json_messages.hpp"

namespace cas::sim {

/// Keeps count of ArduPilot's servo packets: which asks for a step, which only repeats itself, and
/// when the answer is due. Pure.
///
///   packet --> on_packet(): kNew --> steps of the world --> due() --> answered()
class ServoClock {
 public:
  enum class Kind {
    kNew,       ///< asks for the next period
    kRepeated,  ///< the last answer did not arrive: it is wanted again, without a step
    kPending,   ///< repeats the request in progress
    kRestart,   ///< counts from the beginning: a restarted firmware
  };

  struct Counts {
    std::uint64_t packets = 0;  ///< without the repeated
    std::uint64_t repeated = 0;
    std::uint64_t skipped = 0;  ///< packets that never arrived
    std::uint64_t restarts = 0;
  };

  /// @param step  of the world
  explicit ServoClock(base::Duration step) : step_(step) {}

  /// @param now  simulated time
  Kind on_packet(const ServoPacket& packet, base::SimTime now);
  /// Whether a packet has been taken whose answer is not sent yet.
  bool pending() const { return pending_; }
  /// Whether the answer is due at the end of a step.
  bool due(base::SimTime now) const { return pending_ && now + step_ / 2 >= period_end_; }
  void answered() { pending_ = false; }
  const Counts& counts() const { return counts_; }

 private:
  void begin_period(const ServoPacket& packet, base::SimTime now);

  base::Duration step_;
  bool started_ = false;
  bool pending_ = false;
  std::uint32_t frame_count_ = 0;
  base::SimTime period_end_{};
  Counts counts_;
};

}  // namespace cas::sim
