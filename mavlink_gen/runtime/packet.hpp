// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <compare>
#include <cstddef>
#include <cstdint>
#include <span>

/// The wire unit of MAVLink. Source: [MAVLink], Packet Serialization.
///
///   v1  FE len seq sys comp id payload[len] crc[2]
///   v2  FD len incompat compat seq sys comp id[3] payload[len] crc[2] (signature[13])
namespace cas::mav {

inline constexpr std::uint8_t kStartV1 = 0xFE;
inline constexpr std::uint8_t kStartV2 = 0xFD;
inline constexpr std::size_t kHeaderBytesV1 = 6;
inline constexpr std::size_t kHeaderBytesV2 = 10;
inline constexpr std::size_t kChecksumBytes = 2;
inline constexpr std::size_t kSignatureBytes = 13;
inline constexpr std::size_t kMaxPayloadBytes = 255;
inline constexpr std::size_t kMaxPacketBytes =
    kHeaderBytesV2 + kMaxPayloadBytes + kChecksumBytes + kSignatureBytes;
static_assert(kMaxPacketBytes == 280);

/// The one incompatibility flag that is defined: a signature follows the checksum.
inline constexpr std::uint8_t kIncompatSigned = 0x01;

/// Who sent a packet, or whom one is for.
struct Source {
  std::uint8_t system{};
  std::uint8_t component{};

  friend constexpr auto operator<=>(const Source&, const Source&) = default;
};

/// A packet's bytes with their length; nothing is allocated.
struct PacketBuffer {
  std::array<std::uint8_t, kMaxPacketBytes> bytes{};
  std::size_t size{};

  std::span<const std::uint8_t> view() const { return {bytes.data(), size}; }
};

/// Borrowed view of one whole packet.
struct PacketView {
  std::uint8_t version{};  ///< 1 or 2
  std::uint8_t incompat_flags{};
  std::uint8_t compat_flags{};
  std::uint8_t sequence{};  ///< counts up for each sender on each link, modulo 256
  Source source{};
  std::uint32_t message_id{};
  std::span<const std::uint8_t> payload{};  ///< as on the wire: possibly truncated
  std::span<const std::uint8_t> bytes{};    ///< the whole packet

  bool is_signed() const { return (incompat_flags & kIncompatSigned) != 0; }

  /// Link id, timestamp and signature; empty when the packet is not signed.
  std::span<const std::uint8_t> signature() const {
    if (!is_signed()) return {};
    return bytes.last(kSignatureBytes);
  }
};

/// Reads the header of `bytes`, which must be one whole packet of the length its header tells.
inline PacketView view_packet(std::span<const std::uint8_t> bytes) {
  const auto* p = bytes.data();
  PacketView view;
  view.bytes = bytes;
  if (p[0] == kStartV1) {
    view.version = 1;
    view.sequence = p[2];
    view.source = {p[3], p[4]};
    view.message_id = p[5];
    view.payload = bytes.subspan(kHeaderBytesV1, p[1]);
    return view;
  }
  view.version = 2;
  view.incompat_flags = p[2];
  view.compat_flags = p[3];
  view.sequence = p[4];
  view.source = {p[5], p[6]};
  view.message_id =
      p[7] | static_cast<std::uint32_t>(p[8]) << 8U | static_cast<std::uint32_t>(p[9]) << 16U;
  view.payload = bytes.subspan(kHeaderBytesV2, p[1]);
  return view;
}

}  // namespace cas::mav
