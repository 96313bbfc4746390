// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "base/time/clock.hpp"
#include "fcu/protocols/telemetry_messages.hpp"

namespace cas::fcu {

/// The messages that stream, each with its own interval.
///
/// The controls come first: telemetry gets half of what they leave of a line with a baud rate, and
/// answers the rest. Where that is too little, all streams faster than 1 Hz are slowed down by the
/// same factor (PX4's mavlink does so by its data rate, option -r), and one packet follows another
/// when the line has sent it beside the controls, so that these wait for one at most.
class Telemetry {
 public:
  /// @param core, outbox  outlive the telemetry
  Telemetry(const FcuCore& core, Outbox& outbox);

  /// Sends the messages that are due.
  void update(base::RunTime now);
  enum class Sent {
    kSent,
    kNothingYet,  ///< one of ours, but its content is not known yet
    kUnknown,     ///< not one of ours
  };
  /// Sends one message at once.
  Sent send_now(std::uint32_t id, base::RunTime now, int version);
  /// SET_MESSAGE_INTERVAL: microseconds, -1 off, 0 default. @return false when not one of ours
  bool set_interval(std::uint32_t id, double interval_us);
  /// Microseconds, -1 off; nothing of the kind: 0.
  std::int32_t interval_us(std::uint32_t id) const;
  /// Sends HEARTBEAT and EXTENDED_SYS_STATE at the next update (something changed).
  void hurry() { hurry_ = true; }

 private:
  struct Stream {
    std::uint32_t id = 0;
    base::Duration usual{};  // zero: on request only
    double bytes = 0;        // of a packet
    decltype(MessageSource::send) send = nullptr;
    base::Duration interval{};  // zero: off
    base::RunTime next{};
  };
  Stream* find(std::uint32_t id);
  void send(Stream& stream, base::RunTime now);
  void send_on_slow_line(Stream* stream, base::RunTime now);
  void share_line(base::RunTime now);
  double control_bytes() const;
  base::Duration spacing(const Stream& stream) const;

  const FcuCore& core_;
  Outbox& outbox_;
  std::vector<Stream> streams_;
  base::RunTime next_due_{};
  bool hurry_ = false;

  double share_ = 1;     // of the usual rates that the line carries
  double free_b_s_ = 0;  // of the line, beside the controls
  double controls_b_s_ = 0;
  std::optional<base::RunTime> measured_;  // when controls_b_s_ was
  double control_bytes_then_ = 0;
};

}  // namespace cas::fcu
