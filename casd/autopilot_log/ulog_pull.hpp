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
  using LogPull::LogPull;

 private:
  enum class State : std::uint8_t { kIdle, kAsking, kRunning };

  void take(const mav::PacketView& packet) override;
  void ask() override;
  void ask_to_end() override;
  void forget() override;
  void take(const UlogStream::Piece& piece);
  void on_answer(const Outcome& outcome);
  void end_file();

  UlogStream stream_;
  State state_ = State::kIdle;
  std::string last_refusal_;  ///< a sentence
  /// Lives while the request waits for its answer: answers to earlier requests find theirs expired.
  std::shared_ptr<int> request_;
};

}  // namespace cas::casd
