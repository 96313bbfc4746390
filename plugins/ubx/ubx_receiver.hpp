// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <span>
#include <utility>
#include <vector>

#include "base/time/clock.hpp"
#include "plugins/ubx/ubx_frame.hpp"
#include "plugins/ubx/ubx_messages.hpp"

namespace cas::sim {

/// A u-blox receiver behind its UART, without I/O: takes the driver's bytes, answers, and hands out
/// its own at the rate of the line.
///
/// Each CFG message is acknowledged. CFG-VALSET's values are kept and told to CFG-VALGET; those of
/// UART1 that matter act: baud rate, and the messages that go out with each epoch (CFG-MSG sets
/// them, too). CFG-RATE is kept: epochs come as plugin gps makes them. An epoch for which the line
/// has no room before the next is dropped whole.
class UbxReceiver {
 public:
  struct Counts {
    std::uint64_t epochs = 0;
    std::uint64_t dropped = 0;  ///< epochs
    std::uint64_t bytes = 0;
    std::uint64_t answers = 0;  ///< ACK-ACK, ACK-NAK and polls
  };

  explicit UbxReceiver(unsigned baud) : baud_(baud) {}

  void receive(std::span<const std::uint8_t> bytes);
  /// Queues the messages of an epoch that were asked for.
  void on_epoch(const UbxEpoch& epoch);
  /// The bytes that the line takes until `now`. The view lives until the next call.
  std::span<const std::uint8_t> next(base::SimTime now);
  /// The simulation's clock is back at zero; the driver's settings stay.
  void reset();

  /// Whether NAV-PVT was asked for.
  bool configured() const { return rate_of(ubx::kNavPvt) > 0; }
  unsigned baud() const { return baud_; }
  /// Period of the epochs that the driver wants, ms.
  unsigned wanted_period_ms() const;
  const Counts& counts() const { return counts_; }
  const UbxParser::Counts& input() const { return parser_.counts(); }

 private:
  void on_frame(UbxId id, std::span<const std::uint8_t> payload);
  bool configure(UbxId id, std::span<const std::uint8_t> payload);
  bool set_values(std::span<const std::uint8_t> payload);
  bool set_port(std::span<const std::uint8_t> payload);
  bool set_message(std::span<const std::uint8_t> payload);
  bool tell_setting(UbxId id);
  void tell_values(std::span<const std::uint8_t> payload);
  void tell_port();
  void answer(UbxId id, std::span<const std::uint8_t> payload);
  void set_baud(std::uint32_t baud);
  std::uint64_t value_of(std::uint32_t key) const;
  unsigned rate_of(UbxId id) const;

  UbxParser parser_;
  std::map<std::uint32_t, std::uint64_t> values_;               ///< by key, as they were set
  std::map<std::uint8_t, std::vector<std::uint8_t>> settings_;  ///< payloads, by id in class CFG
  std::map<std::pair<std::uint8_t, std::uint8_t>, std::uint8_t> other_rates_;  ///< not sent
  unsigned baud_;
  std::vector<std::uint8_t> queue_;  ///< whole frames
  std::size_t sent_ = 0;             ///< of queue_
  std::size_t epoch_end_ = 0;        ///< of the newest epoch in queue_
  base::SimTime free_at_{};          ///< the line has sent all that it was given
  std::uint64_t number_ = 0;         ///< of epochs, for messages of each n-th
  Counts counts_;
};

}  // namespace cas::sim
