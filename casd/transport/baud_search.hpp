// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <chrono>
#include <cstddef>
#include <utility>
#include <vector>

#include "base/time/clock.hpp"

namespace cas::casd {

/// Finds which of several baud rates the other side of a line has: listens at each in turn until
/// packets with a right checksum come. Pure.
class BaudSearch {
 public:
  /// Vehicles send a HEARTBEAT a second: two come in this time, and one more may be lost.
  static constexpr base::Duration kListen = std::chrono::seconds(3);
  /// Noise has the right checksum of a packet now and then, but not twice in that time.
  static constexpr std::size_t kEnoughPackets = 2;
  /// Bytes without an intact packet for so long: the other side has another rate by now.
  static constexpr base::Duration kDeaf = std::chrono::seconds(5);

  /// @param rates  tried in this order; none or one: there is nothing to find
  explicit BaudSearch(std::vector<unsigned> rates) : rates_(std::move(rates)) {}

  /// The device was opened: begins with the rate that was right the last time.
  void begin(base::RunTime now);
  /// So many intact packets have come at rate(). @return whether they are enough to know it
  bool heard(std::size_t packets);
  /// So many bytes have come at the rate that was found, and intact packets among them.
  /// @return false when the search is to begin again: for kDeaf none of the bytes was readable
  bool fits(std::size_t bytes, std::uint64_t packets, base::RunTime now);
  /// @return true when the next rate is to be set now
  bool advance(base::RunTime now);

  /// What the line is to be set to; 0: the line has no rate.
  unsigned rate() const { return rates_.empty() ? 0 : rates_[at_]; }
  bool found() const { return found_; }
  /// When advance() has something to do; meaningless once it is found.
  base::RunTime due() const { return due_; }

 private:
  std::vector<unsigned> rates_;
  std::size_t at_ = 0;
  std::size_t packets_ = 0;  ///< at this rate
  base::RunTime due_{};
  std::size_t unreadable_ = 0;  ///< bytes since the newest packet at the rate that was found
  base::RunTime unreadable_since_{};
  bool found_ = false;
};

}  // namespace cas::casd
