// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>

#include "mavlink_gen/runtime/crc.hpp"
#include "mavlink_gen/runtime/packet.hpp"

namespace cas::mav {

/// Bytes left of a payload when its trailing zeros are taken off; the first byte always stays.
inline std::size_t truncated_length(std::span<const std::uint8_t> payload) {
  auto size = payload.size();
  while (size > sizeof(std::uint64_t)) {
    std::uint64_t tail;
    std::memcpy(&tail, payload.data() + size - sizeof tail, sizeof tail);
    if (tail != 0) break;
    size -= sizeof tail;
  }
  while (size > 1 && payload[size - 1] == 0) --size;
  return size;
}

namespace detail {

/// Appends the checksum over everything after the start byte, then CRC_EXTRA.
inline std::size_t append_checksum(std::uint8_t* out, std::size_t size, std::uint8_t crc_extra) {
  const std::uint8_t* summed = out + 1;
  const auto crc = Crc16().update({summed, size - 1}).update(crc_extra).value();
  out[size] = static_cast<std::uint8_t>(crc & 0xFFU);
  out[size + 1] = static_cast<std::uint8_t>(crc >> 8U);
  return size + kChecksumBytes;
}

/// Writes header, payload and checksum of a MAVLink 2 packet.
template <class Message>
std::size_t encode_v2(const Message& message, Source source, std::uint8_t sequence,
                      std::uint8_t incompat_flags, std::uint8_t* out) {
  message.pack(out + kHeaderBytesV2);
  const std::uint8_t* payload = out + kHeaderBytesV2;
  const auto length = truncated_length({payload, Message::kMaxLength});
  out[0] = kStartV2;
  out[1] = static_cast<std::uint8_t>(length);
  out[2] = incompat_flags;
  out[3] = 0;
  out[4] = sequence;
  out[5] = source.system;
  out[6] = source.component;
  out[7] = static_cast<std::uint8_t>(Message::kId & 0xFFU);
  out[8] = static_cast<std::uint8_t>(Message::kId >> 8U & 0xFFU);
  out[9] = static_cast<std::uint8_t>(Message::kId >> 16U);
  return append_checksum(out, kHeaderBytesV2 + length, Message::kCrcExtra);
}

}  // namespace detail

/// Packs a message as an unsigned MAVLink 2 packet, trailing zeros cut.
/// @return bytes written
template <class Message>
std::size_t encode(const Message& message, Source source, std::uint8_t sequence,
                   std::span<std::uint8_t, kMaxPacketBytes> out) {
  return detail::encode_v2(message, source, sequence, 0, out.data());
}

/// Packs a message as a MAVLink 1 packet: all base fields, no extensions.
/// @return bytes written
template <class Message>
std::size_t encode_v1(const Message& message, Source source, std::uint8_t sequence,
                      std::span<std::uint8_t, kMaxPacketBytes> out) {
  static_assert(Message::kId <= 0xFF, "MAVLink 1 has one byte for the message id");
  message.pack(out.data() + kHeaderBytesV1);  // the checksum overwrites what extensions left
  out[0] = kStartV1;
  out[1] = static_cast<std::uint8_t>(Message::kMinLength);
  out[2] = sequence;
  out[3] = source.system;
  out[4] = source.component;
  out[5] = static_cast<std::uint8_t>(Message::kId);
  return detail::append_checksum(out.data(), kHeaderBytesV1 + Message::kMinLength,
                                 Message::kCrcExtra);
}

/// A sender of MAVLink 2: knows who it is and counts its packets. One per link; not for several
/// threads.
class Encoder {
 public:
  explicit Encoder(Source source) : source_(source) {}

  /// Packs the message into an own buffer; the bytes hold until the next call.
  template <class Message>
  std::span<const std::uint8_t> operator()(const Message& message) {
    const auto size = detail::encode_v2(message, source_, sequence_++, 0, buffer_.data());
    const std::uint8_t* begin = buffer_.data();
    return {begin, size};
  }

  /// As which the packets are sent.
  Source source() const { return source_; }

 private:
  Source source_;
  std::uint8_t sequence_{};
  std::array<std::uint8_t, kMaxPacketBytes> buffer_{};
};

}  // namespace cas::mav
