// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "mavlink_gen/runtime/crc.hpp"
#include "mavlink_gen/runtime/message_table.hpp"
#include "mavlink_gen/runtime/packet.hpp"
#include "mavlink_gen/runtime/packet_parser.hpp"

// Telemetry logs, as ground stations read and write them. A record is the time as an 8-byte
// big-endian number of microseconds since 1970, then the packet.
namespace cas::mav::services {

inline constexpr std::size_t kTlogStampBytes = 8;
inline constexpr std::size_t kMaxTlogRecordBytes = kTlogStampBytes + kMaxPacketBytes;

/// Length of the record at the start of `bytes` by its packet's header; 0 where no packet follows
/// the stamp, or too little of it is there to tell.
inline std::size_t tlog_record_bytes(std::span<const std::uint8_t> bytes) {
  if (bytes.size() < kTlogStampBytes + 3) return 0;
  const std::uint8_t* packet = bytes.data() + kTlogStampBytes;
  const std::size_t framing = kTlogStampBytes + kChecksumBytes + packet[1];
  if (packet[0] == kStartV1) return framing + kHeaderBytesV1;
  if (packet[0] != kStartV2) return 0;
  const bool is_signed = (packet[2] & kIncompatSigned) != 0;
  return framing + kHeaderBytesV2 + (is_signed ? kSignatureBytes : 0);
}

/// Bytes before the first place at which a record may begin: where a packet's start byte follows a
/// stamp. It finds it in zeros, too, at the speed of memory.
/// @param bytes  at least kTlogStampBytes
inline std::size_t tlog_bytes_to_start(std::span<const std::uint8_t> bytes) {
  const auto packets = bytes.subspan(kTlogStampBytes);
  const auto is_start = [](std::uint8_t byte) { return byte == kStartV1 || byte == kStartV2; };
  return static_cast<std::size_t>(std::find_if(packets.begin(), packets.end(), is_start) -
                                  packets.begin());
}

/// The time of a record, in microseconds since 1970.
inline std::uint64_t tlog_stamp_us(std::span<const std::uint8_t> record) {
  std::uint64_t stamp = 0;
  for (std::size_t i = 0; i < kTlogStampBytes; ++i) stamp = stamp << 8U | record[i];
  return stamp;
}

/// Appends a record to `records`. @param unix_us  microseconds since 1970
inline void append_tlog_record(std::uint64_t unix_us, std::span<const std::uint8_t> packet,
                               std::vector<std::uint8_t>& records) {
  const std::size_t begin = records.size();
  records.resize(begin + kTlogStampBytes + packet.size());  // all of it, or with an exception none
  const auto record = records.begin() + static_cast<std::ptrdiff_t>(begin);
  auto end = record;
  for (int shift = 56; shift >= 0; shift -= 8) {
    *end++ = static_cast<std::uint8_t>(unix_us >> static_cast<unsigned>(shift));
  }
  std::copy(packet.begin(), packet.end(), end);
}

/// The message of a whole record.
inline std::uint32_t tlog_message_id(std::span<const std::uint8_t> record) {
  return view_packet(record.first(tlog_record_bytes(record)).subspan(kTlogStampBytes)).message_id;
}

/// Whether the record at the start of `bytes` is whole and its packet's checksum right.
/// @param table  of the messages; for an id that it does not hold, or without a table, some
/// CRC_EXTRA must fit: one of 256 arbitrary candidates has one
inline bool is_sound_tlog_record(std::span<const std::uint8_t> bytes,
                                 const MessageTable* table = nullptr) {
  const std::size_t size = tlog_record_bytes(bytes);
  if (size == 0 || size > bytes.size()) return false;
  const PacketView packet = view_packet(bytes.subspan(kTlogStampBytes, size - kTlogStampBytes));
  const std::size_t summed =
      static_cast<std::size_t>(packet.payload.data() - packet.bytes.data()) + packet.payload.size();
  const std::uint8_t* sent = packet.bytes.data() + summed;
  const auto received = static_cast<std::uint16_t>(sent[0] | sent[1] << 8U);
  Crc16 sum;
  sum.update(packet.bytes.subspan(1, summed - 1));
  const MessageInfo* info = table == nullptr ? nullptr : table->find(packet.message_id);
  if (info == nullptr) return has_fitting_crc_extra(sum.value(), received);
  return sum.update(info->crc_extra).value() == received;
}

/// One packet of a telemetry log. Its checksum may be wrong, if it lies between two records.
struct TlogRecord {
  std::uint64_t unix_us = 0;
  std::span<const std::uint8_t> packet;
};

/// Splits a telemetry log into its records, however long it is: feed read bytes, then take records
/// until there are none. Bytes that are no record are skipped and counted.
///
/// A record behind another one is believed if its checksum is right, or if it is damaged and ends
/// where a next one begins. Behind any other bytes only the checksum tells a record: a stamp may
/// hold start bytes of packets, and payloads hold anything.
class TlogSplitter {
 public:
  /// @param table  of the messages, to be sure of a checksum; it must outlive the splitter
  explicit TlogSplitter(const MessageTable* table = nullptr) : table_(table) {}

  /// Adds a part of the log. Invalidates the records so far.
  void feed(std::span<const std::uint8_t> bytes) {
    buffer_.erase(buffer_.begin(), buffer_.begin() + static_cast<std::ptrdiff_t>(at_));
    at_ = 0;
    buffer_.insert(buffer_.end(), bytes.begin(), bytes.end());
  }
  /// The next record.
  /// @param whole  nothing more will be fed: a record that is not whole is damage, too
  /// @return nullopt when more must be fed, or at the end
  std::optional<TlogRecord> next(bool whole = false) {
    for (;; skip(1)) {
      const auto rest = std::span<const std::uint8_t>(buffer_).subspan(at_);
      if (rest.size() <= kTlogStampBytes) {
        if (whole) skip(rest.size());
        return std::nullopt;
      }
      if (const std::size_t before = tlog_bytes_to_start(rest); before > 1) {
        skip(before - 1);
        continue;
      }
      if (!whole && rest.size() < kBytesToDecide) return std::nullopt;
      const std::size_t size = tlog_record_bytes(rest);
      if (size == 0 || size > rest.size()) continue;
      if (!is_record(rest, size)) continue;
      at_ += size;
      in_step_ = true;
      return TlogRecord{tlog_stamp_us(rest), rest.subspan(kTlogStampBytes, size - kTlogStampBytes)};
    }
  }
  std::uint64_t skipped_bytes() const { return skipped_; }

 private:
  void skip(std::size_t bytes) {
    at_ += bytes;
    skipped_ += bytes;
    if (bytes > 0) in_step_ = false;
  }

  /// A record, and another one that begins inside it.
  static constexpr std::size_t kBytesToDecide = 2 * kMaxTlogRecordBytes;

  /// Whether a record of this size begins here, be it damaged.
  bool is_record(std::span<const std::uint8_t> rest, std::size_t size) const {
    if (is_sound_tlog_record(rest, table_)) {
      return in_step_ || is_known(rest) || has_none_inside(rest, size);
    }
    const auto behind = rest.subspan(size);
    const bool is_followed = behind.empty() || tlog_record_bytes(behind) != 0;
    return in_step_ && is_followed && has_none_inside(rest, size);
  }

  bool is_known(std::span<const std::uint8_t> record) const {
    return table_ != nullptr && table_->find(tlog_message_id(record)) != nullptr;
  }

  /// A stamp that holds a start byte, or a wrong length, reaches over intact records.
  bool has_none_inside(std::span<const std::uint8_t> rest, std::size_t size) const {
    for (std::size_t inside = 1; inside < size; ++inside) {
      if (is_sound_tlog_record(rest.subspan(inside), table_)) return false;
    }
    return true;
  }

  const MessageTable* table_;
  std::vector<std::uint8_t> buffer_;
  std::size_t at_ = 0;
  bool in_step_ = true;  ///< the last record ends at `at_`
  std::uint64_t skipped_ = 0;
};

/// Hands each intact packet of a telemetry log to `use(unix_us, packet)`; a damaged record costs no
/// other one.
/// @param next  gives the log's TlogRecords one by one, nothing at its end
/// @return counters of all records: those with a wrong checksum among them
template <class Next, class Use>
PacketParser::Stats for_each_tlog_packet(Next&& next, const MessageTable& table, Use&& use) {
  PacketParser parser(table);
  while (const std::optional<TlogRecord> record = next()) {
    parser.reset();
    parser.feed(record->packet, [&](const PacketView& packet) { use(record->unix_us, packet); });
  }
  return parser.stats();
}

}  // namespace cas::mav::services
