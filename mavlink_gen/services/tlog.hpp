// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

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
  for (int shift = 56; shift >= 0; shift -= 8) {
    records.push_back(static_cast<std::uint8_t>(unix_us >> static_cast<unsigned>(shift)));
  }
  records.insert(records.end(), packet.begin(), packet.end());
}

/// One packet of a telemetry log, unchecked.
struct TlogRecord {
  std::uint64_t unix_us = 0;
  std::span<const std::uint8_t> packet;
};

/// Splits a telemetry log into its records, however long it is: feed read bytes, then take records
/// until there are none. Bytes that are no record are skipped and counted.
class TlogSplitter {
 public:
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
    for (;;) {
      const auto rest = std::span<const std::uint8_t>(buffer_).subspan(at_);
      if (rest.size() <= kTlogStampBytes) return std::nullopt;
      if (const std::size_t before = tlog_bytes_to_start(rest); before > 0) {
        skip(before);
        continue;
      }
      if (!whole && rest.size() < kMaxTlogRecordBytes) return std::nullopt;
      const std::size_t size = tlog_record_bytes(rest);
      if (size == 0 || size > rest.size()) {
        skip(1);
        continue;
      }
      at_ += size;
      return TlogRecord{tlog_stamp_us(rest), rest.subspan(kTlogStampBytes, size - kTlogStampBytes)};
    }
  }
  std::uint64_t skipped_bytes() const { return skipped_; }

 private:
  void skip(std::size_t bytes) {
    at_ += bytes;
    skipped_ += bytes;
  }

  std::vector<std::uint8_t> buffer_;
  std::size_t at_ = 0;
  std::uint64_t skipped_ = 0;
};

/// Hands each intact packet of a telemetry log to `use(unix_us, packet)`; a damaged record costs no
/// other one.
/// @param next  gives the log's TlogRecords one by one, nothing at its end
template <class Next, class Use>
void for_each_tlog_packet(Next&& next, const MessageTable& table, Use&& use) {
  PacketParser parser(table);
  while (const std::optional<TlogRecord> record = next()) {
    parser.reset();
    parser.feed(record->packet, [&](const PacketView& packet) { use(record->unix_us, packet); });
  }
}

}  // namespace cas::mav::services
