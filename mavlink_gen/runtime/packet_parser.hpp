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
/// stray start byte never costs a packet. Whole buffers and single bytes give the same packets.
///
/// - A packet of an unknown id is only probably one, so the search goes on inside it at once; it is
///   reported when it is complete.
/// - A MAVLink 1 candidate whose length its message cannot have is none.
/// - A packet with an incompatibility flag that we do not know is dropped as a whole.
///
/// A packet comes out with its last byte. The one exception: a packet that lies within an
/// incomplete candidate of a known id waits until that one is decided (it may be its payload), or
/// for flush().
class PacketParser {
 public:
  /// Counters since construction; reset() keeps them.
  struct Stats {
    std::uint64_t packets{};        ///< intact, known
    std::uint64_t crc_errors{};     ///< candidates of a known id with a wrong checksum
    std::uint64_t unknown_ids{};    ///< probable packets whose id the table does not hold
    std::uint64_t skipped_bytes{};  ///< part of no intact, known packet
    std::uint64_t incompatible{};   ///< intact, dropped for an unknown incompatibility flag
  };

  /// @param table  borrows its storage, which must outlive the parser
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
    while (!bytes.empty()) {
      if (held_size_ > 0) {
        bytes = resume(bytes, on_packet, on_unknown);
        continue;
      }
      bytes = skip_to_start(bytes);
      const auto candidate = inspect(bytes);
      if (bytes.size() < candidate.need) {
        hold(bytes);
        return decide_held(on_packet, on_unknown);
      }
      bytes = bytes.subspan(judge(candidate, bytes, on_packet, on_unknown));
    }
  }

  /// Gives up on candidates that wait for more bytes, e.g. after a pause on the line, and looks for
  /// packets inside them.
  template <class OnPacket>
  void flush(OnPacket&& on_packet) {
    flush(on_packet, [](const PacketView&) {});
  }

  /// Likewise, with on_unknown(const PacketView&) for ids that the table does not hold.
  template <class OnPacket, class OnUnknown>
  void flush(OnPacket&& on_packet, OnUnknown&& on_unknown) {
    while (held_size_ > 0) {
      if (scan_ < held_size_) {
        ++scan_;
        ++stats_.skipped_bytes;
      } else {
        waiting_[0] = false;
      }
      decide_held(on_packet, on_unknown);
    }
  }

  /// What has been found so far.
  const Stats& stats() const { return stats_; }
  /// True while the bytes so far end inside what may be a packet.
  bool inside_packet() const { return held_size_ > 0; }

  /// Forgets a half packet.
  void reset() {
    held_size_ = 0;
    scan_ = 0;
    waiting_ = {};
  }

 private:
  enum class Kind : std::uint8_t { kUndecided, kNone, kUnknown, kPacket };

  /// What the first bytes tell of a packet that may start there.
  struct Candidate {
    Kind kind{};
    std::size_t need{};  ///< bytes to decide about it
    const MessageInfo* info{};
  };

  std::span<const std::uint8_t> skip_to_start(std::span<const std::uint8_t> bytes) {
    std::size_t i = 0;
    while (i < bytes.size() && bytes[i] != kStartV2 && bytes[i] != kStartV1) ++i;
    stats_.skipped_bytes += i;
    return bytes.subspan(i);
  }

  Candidate inspect(std::span<const std::uint8_t> bytes) const {
    if (bytes.empty()) return {Kind::kNone, 0, nullptr};
    return bytes[0] == kStartV1 ? inspect_v1(bytes) : inspect_v2(bytes);
  }

  Candidate inspect_v1(std::span<const std::uint8_t> bytes) const {
    if (bytes.size() < kHeaderBytesV1) return {Kind::kUndecided, kHeaderBytesV1, nullptr};
    const std::size_t length = bytes[1];
    const auto* info = table_.find(std::uint32_t{bytes[5]});
    if (info == nullptr) return unknown(kHeaderBytesV1 + length + kChecksumBytes);
    // Extensions do not belong into MAVLink 1, but some senders put them there.
    if (length < info->min_length || length > info->max_length) return {Kind::kNone, 1, nullptr};
    return {Kind::kPacket, kHeaderBytesV1 + length + kChecksumBytes, info};
  }

  Candidate inspect_v2(std::span<const std::uint8_t> bytes) const {
    if (bytes.size() < kHeaderBytesV2) return {Kind::kUndecided, kHeaderBytesV2, nullptr};
    const std::size_t signature = (bytes[2] & kIncompatSigned) != 0 ? kSignatureBytes : 0;
    const auto need = kHeaderBytesV2 + bytes[1] + kChecksumBytes + signature;
    const auto id = bytes[7] | static_cast<std::uint32_t>(bytes[8]) << 8U |
                    static_cast<std::uint32_t>(bytes[9]) << 16U;
    const auto* info = table_.find(id);
    return info == nullptr ? unknown(need) : Candidate{Kind::kPacket, need, info};
  }

  Candidate unknown(std::size_t need) const {
    if (policy_ == UnknownPolicy::kIgnore) return {Kind::kNone, 1, nullptr};
    return {Kind::kUnknown, need, nullptr};
  }

  // --- complete candidates -----------------------------------------------------------------------

  /// Decides about a candidate at the front of `bytes`; returns the bytes used up.
  template <class OnPacket, class OnUnknown>
  std::size_t judge(const Candidate& candidate, std::span<const std::uint8_t> bytes,
                    OnPacket& on_packet, OnUnknown& on_unknown) {
    if (candidate.kind == Kind::kPacket) {
      return judge_packet(*candidate.info, bytes.first(candidate.need), on_packet);
    }
    if (candidate.kind == Kind::kUnknown) judge_unknown(bytes.first(candidate.need), on_unknown);
    const std::size_t used = bytes.empty() ? 0 : 1;
    stats_.skipped_bytes += used;
    return used;
  }

  template <class OnPacket>
  std::size_t judge_packet(const MessageInfo& info, std::span<const std::uint8_t> bytes,
                           OnPacket& on_packet) {
    const auto packet = view_packet(bytes);
    if (payload_crc(packet).update(info.crc_extra).value() != received_crc(packet)) {
      ++stats_.crc_errors;
      ++stats_.skipped_bytes;
      return 1;
    }
    if (has_unknown_flag(packet)) {
      ++stats_.incompatible;
      stats_.skipped_bytes += bytes.size();
    } else {
      ++stats_.packets;
      on_packet(packet);
    }
    return bytes.size();
  }

  template <class OnUnknown>
  void judge_unknown(std::span<const std::uint8_t> bytes, OnUnknown& on_unknown) {
    const auto packet = view_packet(bytes);
    if (has_unknown_flag(packet)) return;
    if (!has_fitting_crc_extra(payload_crc(packet).value(), received_crc(packet))) return;
    ++stats_.unknown_ids;
    on_unknown(packet);
  }

  static bool has_unknown_flag(const PacketView& packet) {
    return (packet.incompat_flags & ~unsigned{kIncompatSigned}) != 0;
  }

  /// The checksum of everything after the start byte, without CRC_EXTRA.
  static Crc16 payload_crc(const PacketView& packet) {
    return Crc16().update({packet.bytes.data() + 1, packet.payload.data() + packet.payload.size()});
  }

  static std::uint16_t received_crc(const PacketView& packet) {
    const auto* end = packet.payload.data() + packet.payload.size();
    return static_cast<std::uint16_t>(end[0] | end[1] << 8U);
  }

  // --- candidates that wait for more bytes -------------------------------------------------------
  //
  //   held_:  [w . . w . . . | c . . . . . ]
  //            ^0             ^scan_       ^held_size_
  //
  //   w  candidate of an unknown id (waiting_), complete later; behind it is searched already
  //   c  candidate that the search waits for

  std::span<const std::uint8_t> held() const { return {held_.data(), held_size_}; }

  void hold(std::span<const std::uint8_t> bytes) {
    std::memcpy(held_.data(), bytes.data(), bytes.size());
    held_size_ = bytes.size();
    scan_ = 0;
  }

  /// Adds bytes up to the next decision; returns those left over.
  template <class OnPacket, class OnUnknown>
  std::span<const std::uint8_t> resume(std::span<const std::uint8_t> bytes, OnPacket& on_packet,
                                       OnUnknown& on_unknown) {
    const auto missing = decision_at_ - held_size_;
    const auto taken = missing < bytes.size() ? missing : bytes.size();
    std::memcpy(held_.data() + held_size_, bytes.data(), taken);
    held_size_ += taken;
    if (held_size_ == decision_at_) decide_held(on_packet, on_unknown);
    return bytes.subspan(taken);
  }

  /// Searches the held bytes as far as they go, and drops those that nothing waits for.
  template <class OnPacket, class OnUnknown>
  void decide_held(OnPacket& on_packet, OnUnknown& on_unknown) {
    auto scan_end = held_size_ + 1;
    while (scan_ < held_size_) {
      const auto rest = skip_to_start(held().subspan(scan_));
      scan_ = held_size_ - rest.size();
      if (rest.empty()) break;
      const auto candidate = inspect(rest);
      if (candidate.kind == Kind::kUnknown) {
        waiting_[scan_++] = true;
        ++stats_.skipped_bytes;
        continue;
      }
      if (rest.size() < candidate.need) {
        scan_end = scan_ + candidate.need;
        break;
      }
      scan_ += judge(candidate, rest, on_packet, on_unknown);
    }
    const auto waiting_end = report_waiting(on_unknown);
    decision_at_ = waiting_end < scan_end ? waiting_end : scan_end;
    drop_decided();
  }

  /// Reports complete unknown packets in the order of their starts; returns the end of the first
  /// incomplete one, or one past the largest index.
  template <class OnUnknown>
  std::size_t report_waiting(OnUnknown& on_unknown) {
    for (std::size_t i = 0; i < scan_; ++i) {
      if (!waiting_[i]) continue;
      const auto rest = held().subspan(i);
      const auto need = inspect(rest).need;
      if (rest.size() < need) return i + need;
      judge_unknown(rest.first(need), on_unknown);
      waiting_[i] = false;
    }
    return held_.size() + 1;
  }

  void drop_decided() {
    std::size_t keep = 0;
    while (keep < scan_ && !waiting_[keep]) ++keep;
    if (keep == 0) return;
    held_size_ -= keep;
    scan_ -= keep;
    decision_at_ -= keep;
    std::memmove(held_.data(), held_.data() + keep, held_size_);
    std::memmove(waiting_.data(), waiting_.data() + keep, held_size_);
    std::memset(waiting_.data() + held_size_, 0, waiting_.size() - held_size_);
  }

  MessageTable table_;
  UnknownPolicy policy_;
  Stats stats_;
  std::size_t held_size_{};
  std::size_t scan_{};
  std::size_t decision_at_{};
  std::array<std::uint8_t, kMaxPacketBytes> held_{};
  std::array<bool, kMaxPacketBytes> waiting_{};
};

}  // namespace cas::mav
