// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "base/time/clock.hpp"
#include "casd/autopilot_log/log_pull.hpp"

namespace cas::casd {

/// Joins the pieces of PX4's log (LOGGING_DATA, LOGGING_DATA_ACKED) to whole messages of ULog
/// (docs.px4.io, "ULog File Format"). A dropout message replaces those that lost pieces cut. Pure.
class UlogStream {
 public:
  static constexpr std::uint8_t kNoMessage = 255;  ///< no message begins in a piece

  struct Piece {
    std::uint16_t sequence = 0;
    std::uint8_t first_message = kNoMessage;  ///< where in `data` a message begins
    std::span<const std::uint8_t> data;
  };
  /// Whether it is the first piece of a new log. A repetition is not: it has the same header, with
  /// the same time stamp.
  bool begins(const Piece& piece) const;
  /// @return bytes for the file: whole messages, or none
  std::vector<std::uint8_t> take(const Piece& piece, base::RunTime now);
  /// Whether the header of a log has come: without it the rest cannot be read.
  bool began() const { return began_; }
  /// Forgets the log; the next one begins with its header.
  void reset() { *this = {}; }

 private:
  static constexpr std::size_t kHeaderBytes = 16;

  void begin(const Piece& piece);
  void take_whole_messages(std::vector<std::uint8_t>& into);

  bool began_ = false;
  std::array<std::uint8_t, kHeaderBytes> header_{};
  std::uint16_t next_ = 0;          ///< sequence of the next piece
  bool cut_ = false;                ///< pieces are lost: waits for the beginning of a message
  std::vector<std::uint8_t> rest_;  ///< of an incomplete message; below 64 KiB
  base::RunTime whole_at_{};        ///< time of the newest piece before a loss
};

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
