// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>

#include "mavlink_gen/runtime/crc.hpp"
#include "mavlink_gen/runtime/message_table.hpp"
#include "mavlink_gen/runtime/packet.hpp"

namespace cas::mav {

/// What becomes of a packet whose id the table does not hold: its checksum cannot be verified.
enum class UnknownPolicy : std::uint8_t {
  kReport,  ///< counted, and given to `on_unknown`, when some CRC_EXTRA would fit its checksum
  kIgnore   ///< passed over without a word
};

/// Finds every intact packet in any bytes.
///
/// MAVLink has no escaping: any byte may look like a start. A candidate is taken for a packet when
/// its checksum is right; when not, the search goes on one byte after the candidate's start, so a
/// stray start byte never costs a packet. Whole buffers and single bytes give the same packets. A
/// packet comes out with its last byte, unless it lies within an earlier candidate that is not yet
/// complete: then with the byte that disproves the candidate, or with flush().
///
/// A packet of an unknown id is only probably one, so the search goes on inside it, too.
/// A packet with an incompatibility flag that we do not know is dropped as a whole.
class PacketParser {
 public:
  struct Stats {
    std::uint64_t packets{};        ///< intact, known
    std::uint64_t crc_errors{};     ///< candidates of a known id with a wrong checksum
    std::uint64_t unknown_ids{};    ///< probable packets whose id the table does not hold
    std::uint64_t skipped_bytes{};  ///< part of no packet
    std::uint64_t incompatible{};   ///< intact, dropped for an unknown incompatibility flag
  };

  /// @param table  must outlive the parser's storage of it: a static table or one kept by the
  /// caller
  explicit PacketParser(const MessageTable& table, UnknownPolicy policy = UnknownPolicy::kReport)
      : table_(table), policy_(policy) {}

  /// Calls on_packet(const PacketView&) for each intact packet, in order. The view lives during the
  /// call only.
  template <class OnPacket>
  void feed(std::span<const std::uint8_t> bytes, OnPacket&& on_packet) {
    feed(bytes, on_packet, [](const PacketView&) {});
  }

  /// Likewise, with on_unknown(const PacketView&) for ids that the table does not hold.
  template <class OnPacket, class OnUnknown>
  void feed(std::span<const std::uint8_t> bytes, OnPacket&& on_packet, OnUnknown&& on_unknown) {
    bytes = resume(bytes, on_packet, on_unknown);
    while (!bytes.empty()) {
      const auto start = find_start(bytes);
      stats_.skipped_bytes += start;
      bytes = bytes.subspan(start);
      const auto need = needed(bytes);
      if (bytes.size() < need) return keep(bytes, need);
      if (!bytes.empty()) bytes = bytes.subspan(judge(bytes.first(need), on_packet, on_unknown));
    }
  }

  /// Gives up on a candidate that waits for more bytes, e.g. after a pause on the line, and looks
  /// for packets inside it.
  template <class OnPacket>
  void flush(OnPacket&& on_packet) {
    const auto ignore = [](const PacketView&) {};
    while (pending_size_ > 0) {
      const auto size = pending_size_ - 1;
      std::array<std::uint8_t, kMaxPacketBytes> rest;
      std::memcpy(rest.data(), pending_.data() + 1, size);
      ++stats_.skipped_bytes;
      pending_size_ = 0;
      feed(std::span(rest).first(size), on_packet, ignore);
    }
  }

  const Stats& stats() const { return stats_; }

  /// Forgets a half packet.
  void reset() { pending_size_ = 0; }

 private:
  /// Bytes that tell the length of a candidate.
  static constexpr std::size_t kBytesForLength = 3;

  static std::size_t find_start(std::span<const std::uint8_t> bytes) {
    std::size_t i = 0;
    while (i < bytes.size() && bytes[i] != kStartV2 && bytes[i] != kStartV1) ++i;
    return i;
  }

  /// Length of the candidate at the front, as far as its first bytes tell.
  static std::size_t needed(std::span<const std::uint8_t> bytes) {
    if (bytes.empty()) return 0;
    if (bytes.size() < kBytesForLength) return kBytesForLength;
    if (bytes[0] == kStartV1) return kHeaderBytesV1 + bytes[1] + kChecksumBytes;
    const std::size_t signature = (bytes[2] & kIncompatSigned) != 0 ? kSignatureBytes : 0;
    return kHeaderBytesV2 + bytes[1] + kChecksumBytes + signature;
  }

  void keep(std::span<const std::uint8_t> bytes, std::size_t need) {
    std::memcpy(pending_.data(), bytes.data(), bytes.size());
    pending_size_ = bytes.size();
    pending_need_ = need;
  }

  /// Completes the candidate left over from the call before; returns the bytes not used up.
  template <class OnPacket, class OnUnknown>
  std::span<const std::uint8_t> resume(std::span<const std::uint8_t> bytes, OnPacket& on_packet,
                                       OnUnknown& on_unknown) {
    while (pending_size_ > 0) {
      const auto missing = pending_need_ > pending_size_ ? pending_need_ - pending_size_ : 0;
      const auto taken = missing < bytes.size() ? missing : bytes.size();
      if (taken > 0) {
        std::memcpy(pending_.data() + pending_size_, bytes.data(), taken);
        pending_size_ += taken;
        bytes = bytes.subspan(taken);
      }
      if (pending_size_ < pending_need_) return bytes;
      const std::span<const std::uint8_t> held(pending_.data(), pending_size_);
      pending_need_ = needed(held);
      if (held.size() < pending_need_) continue;
      discard(judge(held.first(pending_need_), on_packet, on_unknown));
    }
    return bytes;
  }

  /// Drops the first bytes of the held ones and moves the next start to the front.
  void discard(std::size_t count) {
    const auto rest = std::span<const std::uint8_t>(pending_.data(), pending_size_).subspan(count);
    const auto start = find_start(rest);
    stats_.skipped_bytes += start;
    const auto left = rest.subspan(start);
    std::memmove(pending_.data(), left.data(), left.size());
    pending_size_ = left.size();
    pending_need_ = needed({pending_.data(), pending_size_});
  }

  /// Decides about a complete candidate; returns the bytes it used up: all, or one.
  template <class OnPacket, class OnUnknown>
  std::size_t judge(std::span<const std::uint8_t> bytes, OnPacket& on_packet,
                    OnUnknown& on_unknown) {
    const auto packet = view_packet(bytes);
    const auto* info = table_.find(packet.message_id);
    const auto* end = packet.payload.data() + packet.payload.size();
    auto crc = Crc16().update({bytes.data() + 1, end});
    const auto received = static_cast<std::uint16_t>(end[0] | end[1] << 8U);
    if (info == nullptr) return judge_unknown(packet, crc.value(), received, on_unknown);
    if (crc.update(info->crc_extra).value() != received) {
      ++stats_.crc_errors;
      ++stats_.skipped_bytes;
      return 1;
    }
    if ((packet.incompat_flags & ~unsigned{kIncompatSigned}) != 0) {
      ++stats_.incompatible;
    } else {
      ++stats_.packets;
      on_packet(packet);
    }
    return bytes.size();
  }

  template <class OnUnknown>
  std::size_t judge_unknown(const PacketView& packet, std::uint16_t crc, std::uint16_t received,
                            OnUnknown& on_unknown) {
    ++stats_.skipped_bytes;
    if (policy_ == UnknownPolicy::kReport &&
        (packet.incompat_flags & ~unsigned{kIncompatSigned}) == 0 &&
        has_fitting_crc_extra(crc, received)) {
      ++stats_.unknown_ids;
      on_unknown(packet);
    }
    return 1;
  }

  MessageTable table_;
  UnknownPolicy policy_;
  Stats stats_;
  std::size_t pending_size_{};
  std::size_t pending_need_{};
  std::array<std::uint8_t, kMaxPacketBytes> pending_{};
};

}  // namespace cas::mav
