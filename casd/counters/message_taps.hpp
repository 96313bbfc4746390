// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <optional>
#include <vector>

#include "base/os/mutex.hpp"
#include "base/time/clock.hpp"
#include "casd/packet/link_id.hpp"
#include "mavlink_gen/runtime/packet.hpp"

namespace cas::casd {

/// Keeps the newest packet of the few messages that a client watches. While none is watched, a
/// packet costs one load.
class MessageTaps {
 public:
  /// A watched message: of one sender, as received on one link.
  struct Key {
    LinkId link = kNoLink;
    std::uint32_t message_id = 0;
    mav::Source source;
    friend bool operator==(const Key&, const Key&) = default;
  };
  struct Sample {
    std::array<std::uint8_t, mav::kMaxPayloadBytes> payload{};
    std::size_t size = 0;
    base::RunTime at{};
    std::uint64_t count = 0;  ///< packets since the first look
  };

  /// From a link's thread, for each packet it received.
  void on_packet(LinkId link, const mav::PacketView& packet, base::RunTime now) {
    const std::uint64_t bits = watched_.load(std::memory_order_relaxed);
    if ((bits & bit_of(packet.message_id)) == 0) return;
    note({link, packet.message_id, packet.source}, packet, now);
  }

  /// Newest packet since the first look. Watching stops when no look came for kPatience. Nothing
  /// before the first packet, or when too many messages are watched.
  std::optional<Sample> look(const Key& key, base::RunTime now);

  static constexpr std::size_t kMaxLooks = 64;
  static constexpr base::Duration kPatience = std::chrono::seconds(5);

 private:
  struct Look {
    Key key;
    Sample sample;
    base::RunTime asked{};
  };
  static std::uint64_t bit_of(std::uint32_t message_id) {
    return std::uint64_t{1} << (message_id & 63U);
  }
  void note(const Key& key, const mav::PacketView& packet, base::RunTime now);
  void expire(base::RunTime now) CAS_REQUIRES(mutex_);

  std::atomic<std::uint64_t> watched_{0};  ///< which message ids, modulo 64
  base::Mutex mutex_;
  std::vector<Look> looks_ CAS_GUARDED_BY(mutex_);
};

}  // namespace cas::casd
