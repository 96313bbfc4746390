// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "base/time/clock.hpp"

namespace cas::casd {

/// Puts the pieces of PX4's log (LOGGING_DATA, LOGGING_DATA_ACKED) together. What comes out are
/// whole messages of ULog (docs.px4.io, "ULog File Format"): where pieces are lost, the message
/// that they cut is left out, and a dropout stands in its place. Pure.
class UlogStream {
 public:
  static constexpr std::uint8_t kNoMessage = 255;  ///< no message begins in a piece

  struct Piece {
    std::uint16_t sequence = 0;
    std::uint8_t first_message = kNoMessage;  ///< where in `data` a message begins
    std::span<const std::uint8_t> data;
  };
  /// Whether it is the first piece of another log. One that comes again is not: it has the header
  /// that is known, time stamp and all.
  bool begins(const Piece& piece) const;
  /// @return what goes to the file: whole messages, or nothing
  std::vector<std::uint8_t> take(const Piece& piece, base::RunTime now);
  /// Whether the beginning of a log has come: before it nothing can be read.
  bool began() const { return began_; }
  /// Pieces of this log that never came.
  std::uint64_t lost() const { return lost_; }
  /// Forgets the log; the next one begins with its header.
  void reset() { *this = {}; }

 private:
  static constexpr std::size_t kHeaderBytes = 16;

  void begin(const Piece& piece);
  void take_whole_messages(std::vector<std::uint8_t>& into);

  bool began_ = false;
  std::array<std::uint8_t, kHeaderBytes> header_{};
  std::uint16_t next_ = 0;          ///< sequence of the piece that is expected
  bool cut_ = false;                ///< something is lost: waits for the beginning of a message
  std::vector<std::uint8_t> rest_;  ///< of a message that has not come whole; below 64 KiB
  base::RunTime whole_at_{};        ///< when the newest piece before a loss came
  std::uint64_t lost_ = 0;
};

}  // namespace cas::casd
