// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <optional>
#include <span>

#include "base/random.hpp"
#include "base/time/clock.hpp"
#include "fcu/line/line_config.hpp"

namespace cas::fcu {

/// One direction of a serial line as a function of time: it never reads a clock.
///
/// Every byte is done at max(now, done) + 10/baud: an idle line saves up no credit. Then come
/// delay, jitter, batching, stalls, bit errors and losses as configured; bytes never overtake each
/// other. Same seed and same calls give the same bytes at the same times.
///
///   write --> send buffer --> byte clock --> errors, delay --> receive FIFO --> read
class LineModel {
 public:
  struct Stats {
    std::uint64_t written = 0;    ///< bytes accepted from the writer
    std::uint64_t refused = 0;    ///< bytes the writer had to keep: send buffer full
    std::uint64_t delivered = 0;  ///< bytes read
    std::uint64_t lost = 0;       ///< bytes lost on the line
    std::uint64_t overrun = 0;    ///< bytes lost because nobody read in time
    std::uint64_t flipped = 0;    ///< bits flipped
  };

  LineModel(const LineConfig& config, std::uint64_t seed);

  /// Hands bytes to the line. @return how many it took: fewer than given when the send buffer is
  /// full (back-pressure), none while hung up
  std::size_t write(std::span<const std::uint8_t> bytes, base::RunTime now);
  /// Bytes that write() would take now.
  std::size_t room(base::RunTime now) const;
  /// Moment at which room for one byte appears; nothing when there is room or never will be.
  std::optional<base::RunTime> room_at(base::RunTime now) const;

  /// Moves bytes that have arrived by `now` into `out`. @return how many
  std::size_t read(std::span<std::uint8_t> out, base::RunTime now);
  /// When to read next: a write's last byte, or `receive_trigger_bytes` of it, has arrived. Nothing
  /// while the line is empty.
  std::optional<base::RunTime> next_arrival() const;

  /// New settings for bytes written from now on.
  void configure(const LineConfig& config) { config_ = config; }
  const LineConfig& config() const { return config_; }

  /// Cuts the line: what is under way is lost, writes take nothing until restore().
  void hang_up();
  void restore() { hung_up_ = false; }

  const Stats& stats() const { return stats_; }

 private:
  struct Byte {
    base::RunTime arrival;
    std::uint8_t value = 0;
    bool wakes = false;  ///< last byte of a write, or the trigger level within it
  };

  base::Duration byte_time() const;
  base::RunTime clock_byte(base::RunTime now);
  base::RunTime after_stalls(base::RunTime t);
  bool byte_survives();
  std::uint8_t with_bit_errors(std::uint8_t value);
  std::size_t unsent_at(base::RunTime now) const;
  void drop_overrun(base::RunTime now);

  LineConfig config_;
  base::NormalRandom random_;
  std::deque<Byte> on_line_;
  std::deque<base::RunTime> sending_;  ///< done times of bytes not yet clocked out
  base::RunTime done_{};               ///< when the last byte left the sender
  base::RunTime last_arrival_{};
  base::RunTime next_stall_{};
  bool stall_planned_ = false;
  bool in_burst_ = false;
  bool hung_up_ = false;
  std::uint64_t bits_to_next_error_ = 0;
  bool error_planned_ = false;
  Stats stats_;
};

}  // namespace cas::fcu
