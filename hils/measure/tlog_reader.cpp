// SPDX-License-Identifier: BSD-3-Clause
#include "hils/measure/tlog_reader.hpp"

#include <fstream>
#include <iterator>
#include <optional>
#include <span>
#include <vector>

#include "base/error.hpp"
#include "mavlink/common/table.hpp"
#include "mavlink_gen/runtime/packet_parser.hpp"

namespace cas::hils {

namespace {

constexpr std::size_t kStampBytes = 8;
constexpr std::uint8_t kMagicV1 = 0xFE;
constexpr std::uint8_t kMagicV2 = 0xFD;
constexpr std::size_t kFramingV1 = 8;   // header 6, checksum 2
constexpr std::size_t kFramingV2 = 12;  // header 10, checksum 2
constexpr std::size_t kSignature = 13;
constexpr std::uint8_t kIncompatSigned = 0x01;

std::int64_t read_stamp(std::span<const std::uint8_t> bytes) {
  std::uint64_t stamp = 0;
  for (std::size_t i = 0; i < kStampBytes; ++i) stamp = stamp << 8 | bytes[i];
  return static_cast<std::int64_t>(stamp);
}

/// Length of the packet that starts here by its header; nothing when none starts here.
std::optional<std::size_t> packet_length(std::span<const std::uint8_t> bytes) {
  if (bytes.size() < 3) return std::nullopt;
  std::size_t length = 0;
  if (bytes[0] == kMagicV1) {
    length = kFramingV1 + bytes[1];
  } else if (bytes[0] == kMagicV2) {
    length = kFramingV2 + bytes[1] + ((bytes[2] & kIncompatSigned) != 0 ? kSignature : 0);
  } else {
    return std::nullopt;
  }
  if (length > bytes.size()) return std::nullopt;
  return length;
}

std::vector<std::uint8_t> read_file(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  if (!in) throw base::ConfigError("cannot read " + file.string());
  return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
}

}  // namespace

void read_tlog(
    const std::filesystem::path& file,
    const std::function<void(std::int64_t stamp_us, const mav::PacketView&)>& on_packet) {
  const std::vector<std::uint8_t> content = read_file(file);
  std::span<const std::uint8_t> rest(content);
  mav::PacketParser parser(mavlink::common::table());
  while (rest.size() > kStampBytes) {
    const std::int64_t stamp = read_stamp(rest);
    const std::optional<std::size_t> length = packet_length(rest.subspan(kStampBytes));
    if (!length) {
      rest = rest.subspan(1);
      continue;
    }
    parser.reset();
    parser.feed(rest.subspan(kStampBytes, *length),
                [&](const mav::PacketView& packet) { on_packet(stamp, packet); });
    rest = rest.subspan(kStampBytes + *length);
  }
}

}  // namespace cas::hils
