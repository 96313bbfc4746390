// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>

#include "mavlink_gen/runtime/crc.hpp"
#include "mavlink_gen/runtime/crc_over_zeros.hpp"
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
/// Any bytes cost much the same: each is read for a checksum at most twice (Stats::summed_bytes).
///
/// - A packet of an unknown id is only probably one, so the search goes on inside it at once; it is
///   reported when it is complete.
/// - A MAVLink 1 candidate whose length its message cannot have is none.
/// - A packet with an incompatibility flag that we do not know is dropped as a whole; one of an
///   unknown id is none.
///
/// A packet comes out with its last byte. The one exception: a packet that lies within an
/// incomplete candidate of a known id waits until that one is decided (it may be its payload), or
/// for flush().
///
/// A callback may throw: the packet it was called for counts as received and does not come again,
/// and the parser is fit for the next call. Those behind it come out of
/// feed(bytes.last(parser.unread())).
class PacketParser {
 public:
  /// Counters since construction; reset() keeps them.
  struct Stats {
    std::uint64_t packets{};        ///< intact, known
    std::uint64_t crc_errors{};     ///< candidates of a known id with a wrong checksum
    std::uint64_t unknown_ids{};    ///< probable packets whose id the table does not hold
    std::uint64_t skipped_bytes{};  ///< part of no intact, known packet
    std::uint64_t incompatible{};   ///< intact, dropped for an unknown incompatibility flag
    std::uint64_t summed_bytes{};   ///< read for a checksum: work, at most 2 for each byte
    std::uint64_t headers{};        ///< looked at: work, at most 3 for each byte
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
    // A single byte inside a candidate, as a slow UART gives most of them, decides nothing.
    if (bytes.size() == 1 && end_ + 1 < decision_at_) {
      held_[end_++] = bytes.front();
      unread_ = 0;
      return;
    }
    unread_ = bytes.size();
    if (was_left()) decide_held(on_packet, on_unknown);
    while (!bytes.empty()) {
      bytes = end_ > 0 ? resume(bytes, on_packet, on_unknown) : pass(bytes, on_packet, on_unknown);
    }
    unread_ = 0;
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
    if (was_left()) decide_held(on_packet, on_unknown);
    while (end_ > 0) {
      if (scan_ < end_) {
        ++scan_;
        ++stats_.skipped_bytes;
      } else {
        waiting_[begin_] = false;
        --waiting_count_;
      }
      decide_held(on_packet, on_unknown);
    }
  }

  /// What has been found so far.
  const Stats& stats() const { return stats_; }
  /// Bytes at the end of what feed() was given that it did not come to, because a callback threw.
  std::size_t unread() const { return unread_; }
  /// True while the bytes so far end inside what may be a packet.
  bool inside_packet() const { return end_ > 0; }

  /// Forgets a half packet.
  void reset() {
    forget_held();
    waiting_ = {};
    waiting_count_ = 0;
  }

 private:
  enum class Kind : std::uint8_t { kUndecided, kNone, kUnknown, kPacket };

  /// What the first bytes tell of a packet that may start there.
  struct Candidate {
    Kind kind{};
    std::size_t need{};  ///< bytes to decide about it
    const MessageInfo* info{};
  };

  static std::size_t bytes_before_start(std::span<const std::uint8_t> bytes) {
    std::size_t i = 0;
    while (i < bytes.size() && bytes[i] != kStartV2 && bytes[i] != kStartV1) ++i;
    return i;
  }

  Candidate inspect(std::span<const std::uint8_t> bytes) {
    ++stats_.headers;
    return bytes[0] == kStartV1 ? inspect_v1(bytes) : inspect_v2(bytes);
  }

  Candidate inspect_v1(std::span<const std::uint8_t> bytes) const {
    if (bytes.size() < kHeaderBytesV1) return {Kind::kUndecided, kHeaderBytesV1, nullptr};
    const std::size_t length = bytes[1];
    const auto* info = table_.find(std::uint32_t{bytes[5]});
    if (info == nullptr) return unknown(packet_size(bytes));
    // Extensions do not belong into MAVLink 1, but some senders put them there.
    if (length < info->min_length || length > info->max_length) return {Kind::kNone, 1, nullptr};
    return {Kind::kPacket, packet_size(bytes), info};
  }

  Candidate inspect_v2(std::span<const std::uint8_t> bytes) const {
    if (bytes.size() < kHeaderBytesV2) return {Kind::kUndecided, kHeaderBytesV2, nullptr};
    const auto id = bytes[7] | static_cast<std::uint32_t>(bytes[8]) << 8U |
                    static_cast<std::uint32_t>(bytes[9]) << 16U;
    const auto* info = table_.find(id);
    if (info == nullptr) {
      if (has_unknown_flag(bytes[2])) return {Kind::kNone, 1, nullptr};  // before any checksum
      return unknown(packet_size(bytes));
    }
    return {Kind::kPacket, packet_size(bytes), info};
  }

  Candidate unknown(std::size_t need) const {
    if (policy_ == UnknownPolicy::kIgnore) return {Kind::kNone, 1, nullptr};
    return {Kind::kUnknown, need, nullptr};
  }

  // --- bytes as they come ------------------------------------------------------------------------

  /// Takes packets out of `bytes` without a copy; returns the bytes left, when a candidate is held.
  template <class OnPacket, class OnUnknown>
  std::span<const std::uint8_t> pass(std::span<const std::uint8_t> bytes, OnPacket& on_packet,
                                     OnUnknown& on_unknown) {
    std::size_t read = 0;  // bytes at the front that a candidate's checksum has read
    const auto advance = [&](std::size_t count) {
      bytes = bytes.subspan(count);
      read = read > count ? read - count : 0;
    };
    while (true) {
      const auto skipped = bytes_before_start(bytes);
      stats_.skipped_bytes += skipped;
      advance(skipped);
      if (bytes.empty()) return bytes;
      const auto candidate = inspect(bytes);
      if (candidate.kind == Kind::kNone) {
        ++stats_.skipped_bytes;
        advance(1);
        continue;
      }
      if (read > 0 || bytes.size() < candidate.need) {
        const auto wanted = read > candidate.need ? read : candidate.need;
        const auto taken = wanted < bytes.size() ? wanted : bytes.size();
        hold(bytes.first(taken), read);
        bytes = bytes.subspan(taken);
        unread_ = bytes.size();
        decide_held(on_packet, on_unknown);
        return bytes;
      }
      const auto packet = bytes.first(candidate.need);
      const auto sum = Crc16().update(summed(packet));
      stats_.summed_bytes += summed(packet).size();
      read = candidate.need;
      const bool right = candidate.kind == Kind::kPacket && is_right(*candidate.info, packet, sum);
      advance(right ? packet.size() : 1);
      unread_ = bytes.size();
      if (right) {
        deliver(packet, on_packet);
        continue;
      }
      ++stats_.skipped_bytes;
      if (candidate.kind == Kind::kUnknown) judge_unknown(packet, sum, on_unknown);
    }
  }

  /// What the checksum takes in: everything after the start byte but checksum and signature.
  static std::span<const std::uint8_t> summed(std::span<const std::uint8_t> packet) {
    return packet.subspan(1, header_bytes(packet) - 1 + packet[1]);
  }

  /// By its header.
  static std::size_t packet_size(std::span<const std::uint8_t> bytes) {
    const bool is_signed = bytes[0] == kStartV2 && (bytes[2] & kIncompatSigned) != 0;
    return header_bytes(bytes) + bytes[1] + kChecksumBytes + (is_signed ? kSignatureBytes : 0);
  }

  static std::size_t header_bytes(std::span<const std::uint8_t> packet) {
    return packet[0] == kStartV1 ? kHeaderBytesV1 : kHeaderBytesV2;
  }

  static std::uint16_t received_crc(std::span<const std::uint8_t> packet) {
    const auto* end = packet.data() + header_bytes(packet) + packet[1];
    return static_cast<std::uint16_t>(end[0] | end[1] << 8U);
  }

  /// Judges a candidate by the checksum of its summed() bytes.
  bool is_right(const MessageInfo& info, std::span<const std::uint8_t> packet, Crc16 sum) {
    const bool right = sum.update(info.crc_extra).value() == received_crc(packet);
    if (!right) ++stats_.crc_errors;
    return right;
  }

  /// The bytes are used up already: a callback that throws does not get the packet again.
  template <class OnPacket>
  void deliver(std::span<const std::uint8_t> bytes, OnPacket& on_packet) {
    const auto packet = view_packet(bytes);
    if (has_unknown_flag(packet.incompat_flags)) {
      ++stats_.incompatible;
      stats_.skipped_bytes += bytes.size();
    } else {
      ++stats_.packets;
      on_packet(packet);
    }
  }

  template <class OnUnknown>
  void judge_unknown(std::span<const std::uint8_t> bytes, Crc16 sum, OnUnknown& on_unknown) {
    if (!has_fitting_crc_extra(sum.value(), received_crc(bytes))) return;
    ++stats_.unknown_ids;
    on_unknown(view_packet(bytes));
  }

  static bool has_unknown_flag(std::uint8_t incompat_flags) {
    return (incompat_flags & ~unsigned{kIncompatSigned}) != 0;
  }

  // --- candidates that wait for more bytes or overlap --------------------------------------------
  //
  //   held_:  . . . [w . . w . . . | c . . . . . ] . . .
  //                  ^begin_        ^scan_        ^end_
  //
  //   w  candidate of an unknown id (waiting_), complete later; behind it is searched already
  //   c  candidate that the search waits for

  void hold(std::span<const std::uint8_t> bytes, std::size_t read) {
    std::memcpy(held_.data(), bytes.data(), bytes.size());
    end_ = bytes.size();
    read_end_ = read;
  }

  void forget_held() {
    begin_ = scan_ = end_ = decision_at_ = 0;
    read_end_ = running_end_ = 0;
  }

  /// Whether a callback threw while held bytes were decided about.
  bool was_left() const { return end_ > 0 && decision_at_ == end_; }

  std::span<const std::uint8_t> held(std::size_t from) const {
    return {held_.data() + from, end_ - from};
  }

  /// Adds bytes up to the next decision; returns those left over.
  template <class OnPacket, class OnUnknown>
  std::span<const std::uint8_t> resume(std::span<const std::uint8_t> bytes, OnPacket& on_packet,
                                       OnUnknown& on_unknown) {
    const auto missing = decision_at_ - end_;
    const auto taken = missing < bytes.size() ? missing : bytes.size();
    std::memcpy(held_.data() + end_, bytes.data(), taken);
    end_ += taken;
    bytes = bytes.subspan(taken);
    unread_ = bytes.size();
    if (end_ == decision_at_) decide_held(on_packet, on_unknown);
    return bytes;
  }

  /// Searches the held bytes as far as they go, and drops those that nothing waits for.
  template <class OnPacket, class OnUnknown>
  void decide_held(OnPacket& on_packet, OnUnknown& on_unknown) {
    decision_at_ = end_;
    auto scan_end = end_ + 1;
    while (true) {
      const auto skipped = bytes_before_start(held(scan_));
      stats_.skipped_bytes += skipped;
      scan_ += skipped;
      if (scan_ == end_) break;
      const auto rest = held(scan_);
      const auto candidate = inspect(rest);
      if (candidate.kind == Kind::kPacket || candidate.kind == Kind::kUndecided) {
        if (rest.size() < candidate.need) {
          scan_end = scan_ + candidate.need;
          break;
        }
        const auto packet = rest.first(candidate.need);
        if (is_right(*candidate.info, packet, held_sum(packet))) {
          scan_ += packet.size();
          deliver(packet, on_packet);
          continue;
        }
      }
      if (candidate.kind == Kind::kUnknown) {
        waiting_[scan_] = true;
        ++waiting_count_;
      }
      ++scan_;
      ++stats_.skipped_bytes;
    }
    const auto waiting_end = report_waiting(on_unknown);
    decision_at_ = waiting_end < scan_end ? waiting_end : scan_end;
    drop_decided();
  }

  /// Reports complete unknown packets in the order of their starts; returns the end of the first
  /// incomplete one, or one past the largest index. Nothing before begin_ waits any more.
  template <class OnUnknown>
  std::size_t report_waiting(OnUnknown& on_unknown) {
    for (; waiting_count_ > 0; ++begin_) {
      if (!waiting_[begin_]) continue;
      const auto rest = held(begin_);
      const auto need = packet_size(rest);
      if (rest.size() < need) return begin_ + need;
      waiting_[begin_] = false;
      --waiting_count_;
      const auto packet = rest.first(need);
      judge_unknown(packet, held_sum(packet), on_unknown);
    }
    begin_ = scan_;
    return held_.size() + 1;
  }

  void drop_decided() {
    if (begin_ == end_) return forget_held();
    if (begin_ < kMaxPacketBytes) return;  // what waits is at most one packet long, so it has room
    std::memmove(held_.data(), held_.data() + begin_, end_ - begin_);
    std::memmove(waiting_.data(), waiting_.data() + begin_, scan_ - begin_);
    std::memset(waiting_.data() + scan_ - begin_, 0, begin_);
    keep_running();
    std::memmove(running_.data(), running_.data() + begin_,
                 (running_end_ - begin_ + 1) * sizeof(std::uint16_t));
    read_end_ = read_end_ > begin_ ? read_end_ - begin_ : 0;
    running_end_ -= begin_;
    end_ -= begin_;
    scan_ -= begin_;
    decision_at_ -= begin_;
    begin_ = 0;
  }

  // --- checksums of held candidates --------------------------------------------------------------
  //
  // Candidates overlap. What none has read yet is summed at once; over the rest goes one running
  // checksum, whose values at both ends of a candidate tell that of the candidate.

  /// The checksum of the summed() bytes of a candidate that lies in held_.
  Crc16 held_sum(std::span<const std::uint8_t> packet) {
    const auto bytes = summed(packet);
    const auto from = static_cast<std::size_t>(bytes.data() - held_.data());
    const auto to = from + bytes.size();
    if (from >= read_end_) {
      read_end_ = to;
      stats_.summed_bytes += bytes.size();
      return Crc16().update(bytes);
    }
    run_to(to);
    return Crc16(static_cast<std::uint16_t>(
        running_[to] ^ crc_over_zeros(running_[from] ^ Crc16().value(), bytes.size())));
  }

  void run_to(std::size_t to) {
    keep_running();
    if (running_end_ >= to) return;
    stats_.summed_bytes += to - running_end_;
    Crc16 crc(running_[running_end_]);
    for (; running_end_ < to; ++running_end_) {
      running_[running_end_ + 1] = crc.update(held_[running_end_]).value();
    }
  }

  /// The running checksum may begin anywhere: nothing needs it before begin_.
  void keep_running() {
    if (running_end_ >= begin_) return;
    running_end_ = begin_;
    running_[begin_] = 0;
  }

  MessageTable table_;
  UnknownPolicy policy_;
  Stats stats_;
  std::size_t begin_{}, scan_{}, end_{};
  std::size_t unread_{};
  std::size_t decision_at_{};  ///< end_ at which something can be decided; 0 when none is held
  std::size_t read_end_{};     ///< bytes behind it were read for no checksum
  std::size_t running_end_{};  ///< last element of running_ that is computed
  std::array<std::uint8_t, 2 * kMaxPacketBytes> held_{};
  std::size_t waiting_count_{};
  std::array<bool, 2 * kMaxPacketBytes> waiting_{};
  std::array<std::uint16_t, 2 * kMaxPacketBytes + 1> running_{};  ///< [i]: checksum up to held_[i]
};

}  // namespace cas::mav
