// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <string_view>

/// The words of MCAP files. Source: mcap.dev/spec, version 0.
namespace cas::hils {

static_assert(std::endian::native == std::endian::little, "MCAP is little-endian");

/// Begin and end of a file.
inline constexpr std::string_view kMcapMagic{"\x89MCAP0\r\n", 8};
/// Bytes of a record before its content: opcode and length (uint64).
inline constexpr std::size_t kMcapRecordHead = 9;
/// Bytes of a message before its data: channel, sequence, time of log, time of publication.
inline constexpr std::size_t kMcapMessageHead = 22;

enum class McapOpcode : std::uint8_t {
  kHeader = 0x01,
  kFooter = 0x02,
  kSchema = 0x03,
  kChannel = 0x04,
  kMessage = 0x05,
  kChunk = 0x06,
  kMessageIndex = 0x07,
  kChunkIndex = 0x08,
  kAttachment = 0x09,
  kStatistics = 0x0B,
  kMetadata = 0x0C,
  kMetadataIndex = 0x0D,
  kSummaryOffset = 0x0E,
  kDataEnd = 0x0F,
};

}  // namespace cas::hils
