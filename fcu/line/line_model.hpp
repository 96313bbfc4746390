// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "base/config/config.hpp"
#include "base/random.hpp"
#include "base/time/clock.hpp"

namespace cas::fcu {

/// Properties of one direction of a serial line. Zero switches an effect off.
struct LineConfig {
  std::string preset = "ideal";  ///< ideal | usb | baud_921600 | baud_460800 | baud_115200
  double baud = 0;               ///< byte clock, 10 bits a byte; 0 = no byte clock
  double clock_drift_ppm = 0;    ///< sender's clock against its nominal rate; positive is slow
  base::Duration extra_delay{};  ///< added to every byte
  base::Duration jitter{};       ///< uniform 0..jitter added per write, order is kept
  base::Duration batch{};  ///< bytes arrive in batches, one each time this has passed (USB: 1 ms)
  base::Duration stall_every{};       ///< mean time between stalls (exponential)
  base::Duration stall_length{};      ///< how long nothing moves in a stall
  double bit_error_rate = 0;          ///< probability that one bit is flipped
  double burst_begin = 0;             ///< Gilbert-Elliott: probability per byte, good -> bad
  double burst_end = 1;               ///< Gilbert-Elliott: probability per byte, bad -> good
  double burst_loss = 1;              ///< probability that a byte is lost while bad
  double packet_loss = 0;             ///< probability that one write is lost as a whole
  double packet_duplicate = 0;        ///< probability that one write arrives twice
  double packet_reorder = 0;          ///< probability that one write waits for the next one to pass
  double receiver_baud = 0;           ///< rate at which the receiver reads; 0 = the sender's
  std::size_t send_buffer_bytes = 0;  ///< room before the writer is held back; 0 = endless
  std::size_t receive_fifo_bytes =
      0;  ///< bytes that may wait to be read; more overrun; 0 = endless
  /// A receiver is woken after this many bytes of a longer write: the trigger level of its FIFO.
  std::size_t receive_trigger_bytes = 128;

  /// The figures behind a preset's name. @throws base::ConfigError for an unknown name
  static LineConfig from_preset(const std::string& name);
  /// Reads a `line:` block: a preset and the keys that override it (durations as *_us).
  static LineConfig parse(const base::ConfigNode& node);
};

/// The byte that a UART with another bit time reads (8N1): it samples the middle of each of its own
/// bits, counted from the start bit's edge. The line is assumed idle after the byte.
///
/// @param ratio  receiver's bit time over the sender's
/// @return nullopt if the stop bit reads 0: a framing error, which loses the byte
std::optional<std::uint8_t> read_at_other_rate(std::uint8_t sent, double ratio);

/// One direction of a serial line as a function of time: it never reads a clock.
///
/// Every byte is done at max(now, done) + 10/baud: an idle line saves up no credit. Then come
/// delay, jitter, batching, stalls, bit errors and losses as configured; bytes never overtake each
/// other. A write that waits for the next one to pass waits 50 ms at most. Same seed and same calls
/// give the same bytes at the same times.
///
///   write --> send buffer --> byte clock --> errors, delay --> receive FIFO --> read
class LineModel {
 public:
  struct Stats {
    std::uint64_t written = 0;     ///< bytes accepted from the writer
    std::uint64_t duplicated = 0;  ///< bytes put on the line once more
    std::uint64_t refused = 0;     ///< bytes the writer had to keep: send buffer full
    std::uint64_t delivered = 0;   ///< bytes read
    std::uint64_t lost = 0;        ///< bytes lost on the line
    std::uint64_t overrun = 0;     ///< bytes lost because the reader was late
    std::uint64_t flipped = 0;     ///< bits flipped
    std::uint64_t misread = 0;     ///< bytes that the receiver took for others, at another rate
  };

  LineModel(const LineConfig& config, std::uint64_t seed);

  /// Hands bytes to the line. @return how many it took: fewer than given when the send buffer is
  /// full (back-pressure), none while hung up
  std::size_t write(std::span<const std::uint8_t> bytes, base::RunTime now);
  /// Bytes that write() would take now.
  std::size_t room(base::RunTime now) const;
  /// Moment at which room for one byte appears; nullopt when there is room or never will be.
  std::optional<base::RunTime> room_at(base::RunTime now) const;

  /// Moves bytes that have arrived by `now` into `out`. @return how many
  std::size_t read(std::span<std::uint8_t> out, base::RunTime now);
  /// When to read next: a write's last byte, or `receive_trigger_bytes` of it, has arrived, or one
  /// that waits goes on the line. nullopt while the line is empty.
  std::optional<base::RunTime> next_arrival() const;

  /// New settings for bytes written from now on.
  void configure(const LineConfig& config) { config_ = config; }
  const LineConfig& config() const { return config_; }

  /// Cuts the line: bytes on their way are lost, writes take nothing until restore().
  void hang_up();
  void restore() { hung_up_ = false; }

  const Stats& stats() const { return stats_; }

 private:
  /// Moments of bytes that follow each other evenly.
  struct EvenTimes {
    base::RunTime first;       ///< of the first, before `batch` and `earliest`
    base::Duration step{};     ///< from one to the next
    std::size_t count = 1;     ///< how many bytes
    base::Duration batch{};    ///< rounded up to a multiple of it; 0: not
    base::RunTime earliest{};  ///< none is before it

    base::RunTime at(std::size_t i) const;
    /// How many of them are not later than `t`.
    std::size_t count_by(base::RunTime t) const;
  };

  /// Bytes of one write on their way.
  struct Stretch {
    EvenTimes arrivals;
    std::size_t trigger = 0;  ///< each so many bytes of it wake the receiver; 0: none do
    bool wakes = false;       ///< its last byte does
    std::size_t read = 0;     ///< how many of its bytes have been read

    std::size_t left() const { return arrivals.count - read; }
    bool wakes_at(std::size_t i) const;
    /// The next of its bytes that wakes the receiver.
    std::optional<base::RunTime> next_wake() const;
  };

  /// A write that the next one is to pass.
  struct Held {
    std::vector<std::uint8_t> bytes;
    bool twice = false;
  };
  static constexpr base::Duration kLongestHold = std::chrono::milliseconds(50);

  void send(std::span<const std::uint8_t> bytes, base::RunTime now);
  bool is_even() const;
  void send_evenly(std::span<const std::uint8_t> bytes, base::Duration delay, base::RunTime now);
  void send_singly(std::span<const std::uint8_t> bytes, base::Duration delay, bool lost,
                   base::RunTime now);
  void put(std::span<const std::uint8_t> bytes, bool twice, base::RunTime now);
  void release(base::RunTime now);
  void release_overdue(base::RunTime now);
  base::Duration byte_time() const;
  void note_sending(const EvenTimes& done);
  base::RunTime clock_byte(base::RunTime now, base::Duration byte_time);
  base::RunTime after_stalls(base::RunTime t);
  bool byte_survives();
  std::uint8_t with_bit_errors(std::uint8_t value);
  std::size_t unsent_at(base::RunTime now) const;
  std::size_t arrived_by(base::RunTime now) const;
  void part_stretches();
  void drop_overrun(base::RunTime now);

  LineConfig config_;
  base::NormalRandom random_;
  std::deque<Stretch> on_line_;
  std::deque<std::uint8_t> values_;  ///< of the bytes on the line
  std::deque<EvenTimes> sending_;    ///< when bytes are done that are not yet clocked out
  std::vector<Held> held_;           ///< oldest first
  base::RunTime held_until_{};       ///< when the oldest of them has waited long enough
  base::RunTime done_{};             ///< when the last byte left the sender
  base::RunTime last_arrival_{};
  base::RunTime next_stall_{};
  bool stall_planned_ = false;
  bool in_burst_ = false;
  bool hung_up_ = false;
  std::uint64_t bits_to_next_error_ = 0;
  bool error_planned_ = false;
  Stats stats_;
};

/// The emulated controller's serial line in both directions. Downwards only whole packets enter: a
/// packet without room in the send buffer is dropped and counted, as a controller's driver does.
class EmulatorLine {
 public:
  EmulatorLine(const LineConfig& config, std::uint64_t seed);

  // Towards the controller.
  std::size_t up_room(base::RunTime now) const;
  void receive(std::span<const std::uint8_t> bytes, base::RunTime now) { up_.write(bytes, now); }
  std::size_t up(std::span<std::uint8_t> out, base::RunTime now) { return up_.read(out, now); }

  // From the controller.
  void send(std::span<const std::uint8_t> packet, base::RunTime now);
  std::size_t down(std::span<std::uint8_t> out, base::RunTime now) { return down_.read(out, now); }
  /// The reader has stopped: further packets are dropped while `held`.
  void hold(bool held) { held_ = held; }

  /// When something arrives at either end, or room appears for waiting bytes.
  std::optional<base::RunTime> next_event(base::RunTime now) const;

  void configure(const LineConfig& config);
  const LineConfig& config() const { return up_.config(); }
  void hang_up();
  void restore();

  const LineModel::Stats& up_stats() const { return up_.stats(); }
  const LineModel::Stats& down_stats() const { return down_.stats(); }
  std::uint64_t dropped_packets() const { return dropped_packets_; }

 private:
  LineModel up_;
  LineModel down_;
  bool held_ = false;
  std::uint64_t dropped_packets_ = 0;
};

}  // namespace cas::fcu
