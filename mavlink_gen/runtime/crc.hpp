// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>

namespace cas::mav {
namespace detail {

using CrcTables = std::array<std::array<std::uint16_t, 256>, 8>;

/// Table k advances the checksum over one byte that k more bytes follow.
constexpr CrcTables make_crc_tables() {
  constexpr std::uint16_t kReflectedPolynomial = 0x8408;  // 0x1021 with its bits mirrored
  CrcTables tables{};
  for (unsigned i = 0; i < 256; ++i) {
    unsigned crc = i;
    for (int bit = 0; bit < 8; ++bit) {
      crc = (crc & 1U) != 0 ? (crc >> 1U) ^ kReflectedPolynomial : crc >> 1U;
    }
    tables[0][i] = static_cast<std::uint16_t>(crc);
  }
  for (std::size_t k = 1; k < 8; ++k) {
    for (std::size_t i = 0; i < 256; ++i) {
      const unsigned before = tables[k - 1][i];
      tables[k][i] = static_cast<std::uint16_t>((before >> 8U) ^ tables[0][before & 0xFFU]);
    }
  }
  return tables;
}

inline constexpr CrcTables kCrcTables = make_crc_tables();

}  // namespace detail

/// MAVLink's checksum ([MAVLink], Packet Serialization), CRC-16/MCRF4XX: polynomial 0x1021
/// reflected, start 0xFFFF, no final xor. Takes eight bytes at once where it can.
class Crc16 {
 public:
  constexpr Crc16() = default;

  /// Takes further bytes in.
  Crc16& update(std::span<const std::uint8_t> bytes) {
    const auto& t = detail::kCrcTables;
    unsigned crc = value_;
    const auto* p = bytes.data();
    auto left = bytes.size();
    if constexpr (std::endian::native == std::endian::little) {
      for (; left >= 8; left -= 8, p += 8) {
        std::uint64_t word;
        std::memcpy(&word, p, sizeof word);
        word ^= crc;
        crc = static_cast<unsigned>(t[7][word & 0xFFU] ^ t[6][(word >> 8U) & 0xFFU] ^
                                    t[5][(word >> 16U) & 0xFFU] ^ t[4][(word >> 24U) & 0xFFU] ^
                                    t[3][(word >> 32U) & 0xFFU] ^ t[2][(word >> 40U) & 0xFFU] ^
                                    t[1][(word >> 48U) & 0xFFU] ^ t[0][word >> 56U]);
      }
    }
    for (; left > 0; --left, ++p) crc = (crc >> 8U) ^ t[0][(crc ^ *p) & 0xFFU];
    value_ = static_cast<std::uint16_t>(crc);
    return *this;
  }

  constexpr Crc16& update(std::uint8_t byte) {
    value_ =
        static_cast<std::uint16_t>((value_ >> 8U) ^ detail::kCrcTables[0][(value_ ^ byte) & 0xFFU]);
    return *this;
  }

  /// The checksum of all bytes so far; on the wire low byte first.
  constexpr std::uint16_t value() const { return value_; }

 private:
  std::uint16_t value_{0xFFFF};
};

/// Whether some CRC_EXTRA would make `received` the right checksum after `payload_crc`: of 256
/// arbitrary pairs about 255 have none.
constexpr bool has_fitting_crc_extra(std::uint16_t payload_crc, std::uint16_t received) {
  // update() xors the table entry into the shifted checksum; the entry must exist.
  const auto wanted = static_cast<std::uint16_t>(received ^ (payload_crc >> 8U));
  for (const auto entry : detail::kCrcTables[0]) {
    if (entry == wanted) return true;
  }
  return false;
}

}  // namespace cas::mav
