// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "mavlink_gen/runtime/packet.hpp"

/// One record of a telemetry log, as ground stations read it: the time as an 8-byte big-endian
/// number of microseconds since 1970, then the packet.
namespace cas::casd {

inline constexpr std::size_t kTlogStampBytes = 8;
inline constexpr std::size_t kMaxTlogRecordBytes = kTlogStampBytes + mav::kMaxPacketBytes;

/// Length of the record at the start of `bytes` by its packet's header; 0 where no packet follows
/// the stamp, or too little of it is there to tell.
inline std::size_t tlog_record_bytes(std::span<const std::uint8_t> bytes) {
  if (bytes.size() < kTlogStampBytes + 3) return 0;
  const std::uint8_t* packet = bytes.data() + kTlogStampBytes;
  const std::size_t framing = kTlogStampBytes + mav::kChecksumBytes + packet[1];
  if (packet[0] == mav::kStartV1) return framing + mav::kHeaderBytesV1;
  if (packet[0] != mav::kStartV2) return 0;
  const bool is_signed = (packet[2] & mav::kIncompatSigned) != 0;
  return framing + mav::kHeaderBytesV2 + (is_signed ? mav::kSignatureBytes : 0);
}

inline std::uint64_t tlog_stamp_us(std::span<const std::uint8_t> record) {
  std::uint64_t stamp = 0;
  for (std::size_t i = 0; i < kTlogStampBytes; ++i) stamp = stamp << 8U | record[i];
  return stamp;
}

}  // namespace cas::casd
