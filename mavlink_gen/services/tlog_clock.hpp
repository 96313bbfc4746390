// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <span>

#include "mavlink_gen/runtime/packet.hpp"

namespace cas::mav::services {

/// The clock of a packet's sender.
struct SenderClock {
  std::uint16_t sender = 0;  ///< system << 8 | component
  std::uint32_t boot_ms = 0;
};

/// Reads time_boot_ms of SYSTEM_TIME and of the frequent messages that begin with it.
/// @return nullopt: the packet has none, or is no whole packet
inline std::optional<SenderClock> sender_clock_of(std::span<const std::uint8_t> packet) {
  constexpr std::uint32_t kSystemTime = 2;
  constexpr std::size_t kPlaceInSystemTime = 8;
  // Raw sensors, attitude, position, RC channels, targets, distances, named values.
  constexpr std::array<std::uint32_t, 17> kBeginWithIt = {26, 29, 30, 31,  32,  33,  34,  35, 65,
                                                          83, 85, 87, 116, 129, 132, 137, 251};
  if (packet.size() < kHeaderBytesV2) return std::nullopt;
  const bool is_v2 = packet[0] == kStartV2;
  const std::size_t header = is_v2 ? kHeaderBytesV2 : kHeaderBytesV1;
  const std::uint8_t* ids = packet.data() + (is_v2 ? 5 : 3);  // system, component, message
  const std::uint32_t message =
      is_v2 ? ids[2] | std::uint32_t{ids[3]} << 8U | std::uint32_t{ids[4]} << 16U : ids[2];
  const std::size_t place = message == kSystemTime ? kPlaceInSystemTime : 0;
  if (place == 0 && std::ranges::find(kBeginWithIt, message) == kBeginWithIt.end()) {
    return std::nullopt;
  }
  if (packet.size() < header + packet[1]) return std::nullopt;
  const auto payload = packet.subspan(header, packet[1]);
  SenderClock clock{static_cast<std::uint16_t>(ids[0] << 8U | ids[1]), 0};
  for (std::size_t i = 0; i < 4 && place + i < payload.size(); ++i) {  // zeros are left out
    clock.boot_ms |= std::uint32_t{payload[place + i]} << 8U * i;
  }
  return clock;
}

/// The time of a telemetry log's records since the first one, though the recorder's clock may have
/// been set meanwhile: 1970 until a companion hears NTP or GPS, an hour back, a damaged stamp.
///
/// Time follows the stamps. It never goes back, and a stamp that is more than a second before or
/// ten seconds behind the one before it is a step of the recorder's clock: time stands still there,
/// until a packet tells how much time has passed by its sender's own clock (time_boot_ms). So a
/// pause of the recording is kept, too. Stamps that never advance are replaced by the senders'
/// clocks.
class TlogClock {
 public:
  /// Time of the next record since the first one, us.
  /// @param packet  unchecked bytes
  std::int64_t at(std::uint64_t stamp_us, std::span<const std::uint8_t> packet) {
    const std::int64_t step = previous_ ? difference(stamp_us, *previous_) : 0;
    const bool is_step = step > kLongestGap_us || step < -kMostJitter_us;
    if (!previous_ || is_step) {
      from_us_ = stamp_us;
      base_us_ = now_us_;
      steps_ += is_step ? 1 : 0;
    } else if (step != 0) {
      advances_ = true;
    }
    previous_ = stamp_us;
    now_us_ = std::max(now_us_, base_us_ + difference(stamp_us, from_us_));
    if (const auto clock = sender_clock_of(packet)) follow(*clock);
    return now_us_;
  }

  /// How often the recorder's clock was set, or a stamp was damaged.
  std::uint64_t steps() const { return steps_; }

 private:
  static constexpr std::int64_t kMostJitter_us = 1'000'000;
  static constexpr std::int64_t kLongestGap_us = 10'000'000;
  static constexpr std::int64_t kLongestPause_ms = 86'400'000;

  struct Heard {
    std::uint32_t boot_ms = 0;
    std::int64_t at_us = 0;
    std::uint64_t steps = 0;  ///< of the recorder's clock until then
  };

  /// Difference a - b of any two stamps, without overflow.
  static std::int64_t difference(std::uint64_t a, std::uint64_t b) {
    constexpr auto kFarthest = std::uint64_t{1} << 60U;
    if (a >= b) return static_cast<std::int64_t>(std::min(a - b, kFarthest));
    return -static_cast<std::int64_t>(std::min(b - a, kFarthest));
  }

  /// Behind a step the sender tells how much time has passed.
  void follow(const SenderClock& clock) {
    const auto known = heard_.find(clock.sender);
    if (known != heard_.end() && (known->second.steps != steps_ || !advances_)) {
      const std::int64_t passed_ms =
          std::int64_t{clock.boot_ms} - std::int64_t{known->second.boot_ms};
      const std::int64_t late_us = known->second.at_us + 1000 * passed_ms - now_us_;
      if (passed_ms <= kLongestPause_ms && late_us > 0) {
        base_us_ += late_us;
        now_us_ += late_us;
      }
    }
    heard_[clock.sender] = {clock.boot_ms, now_us_, steps_};
  }

  std::optional<std::uint64_t> previous_;
  std::uint64_t from_us_ = 0;  ///< stamp at which time was `base_us_`
  std::int64_t base_us_ = 0;
  std::int64_t now_us_ = 0;
  bool advances_ = false;  ///< some stamp differed from the one before it
  std::uint64_t steps_ = 0;
  std::map<std::uint16_t, Heard> heard_;  ///< by sender
};

}  // namespace cas::mav::services
