// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>

#include "casd/autopilot_log/log_pull.hpp"
#include "casd/autopilot_log/ulog_stream.hpp"

namespace cas::casd {

/// PX4's log: MAV_CMD_LOGGING_START until it is acknowledged, then LOGGING_DATA. PX4 repeats
/// LOGGING_DATA_ACKED every 50 ms until LOGGING_ACK comes, 50 times.
///
///   idle --START--> asking --accepted--> running --silence--> idle
///    ^---- later ------'refused: another log runs? STOP first
class UlogPull final : public LogPull {
 public:
  explicit UlogPull(LogPullHooks hooks) : hooks_(std::move(hooks)) {}

  void on_packet(const mav::PacketView& packet, base::RunTime now) override;
  void tick(base::RunTime now) override;
  void stop(base::RunTime now) override;
  void restart(base::RunTime now) override;

 private:
  enum class State : std::uint8_t { kIdle, kAsking, kRunning };

  void take(const UlogStream::Piece& piece, base::RunTime now);
  void on_answer(const Outcome& outcome);
  void end_file();
  void retry(base::Duration at_least);

  LogPullHooks hooks_;
  UlogStream stream_;
  State state_ = State::kIdle;
  bool wanted_ = false;
  base::RunTime now_{};
  base::RunTime next_ask_{};
  base::RunTime next_file_{};
  base::RunTime heard_at_{};
  base::Duration retry_ = kFirstRetry;
  std::string last_refusal_;  ///< a sentence
  /// Lives while the request waits for its answer: answers to earlier requests find theirs expired.
  std::shared_ptr<int> request_;
};

}  // namespace cas::casd
