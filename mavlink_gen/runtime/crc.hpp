// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>

#include "mavlink_gen/runtime/crc_clmul.hpp"

namespace cas::mav {
namespace detail {

/// An entry of the first table in two steps: the key of a byte, the entry of a key.
constexpr unsigned crc_entry_key(unsigned byte) { return (byte ^ byte << 4U) & 0xFFU; }
constexpr unsigned crc_entry(unsigned key) { return key << 8U ^ key << 3U ^ key >> 4U; }

/// Plain arrays, and no loop over the bits of each: all that sends or receives a packet has the
/// compiler compute them.
struct CrcTables {
  std::uint16_t at[8][256];
};

/// Table k advances the checksum over one byte that k more bytes follow.
constexpr CrcTables make_crc_tables() {
  CrcTables tables{};
  for (unsigned i = 0; i < 256; ++i) {
    tables.at[0][i] = static_cast<std::uint16_t>(crc_entry(crc_entry_key(i)));
  }
  for (unsigned k = 1; k < 8; ++k) {
    for (unsigned i = 0; i < 256; ++i) {
      const unsigned before = tables.at[k - 1][i];
      tables.at[k][i] = static_cast<std::uint16_t>(before >> 8U ^ tables.at[0][before & 0xFFU]);
    }
  }
  return tables;
}

inline constexpr CrcTables kCrcTables = make_crc_tables();

}  // namespace detail

/// MAVLink's checksum ([MAVLink], Packet Serialization), CRC-16/MCRF4XX: polynomial 0x1021
/// reflected, start 0xFFFF, no final xor. Takes many bytes at once where it can.
class Crc16 {
 public:
  constexpr Crc16() = default;
  /// Goes on from a checksum.
  constexpr explicit Crc16(std::uint16_t value) : value_(value) {}

  /// Takes further bytes in.
  Crc16& update(std::span<const std::uint8_t> bytes) {
#ifdef CAS_MAV_CLMUL
    if (bytes.size() >= detail::kLeastClmulBytes && detail::has_clmul) {
      value_ = detail::crc_by_clmul(value_, bytes.data(), bytes.size());
      return *this;
    }
#endif
    return update_by_tables(bytes);
  }

  /// The same by tables, on any processor.
  Crc16& update_by_tables(std::span<const std::uint8_t> bytes) {
    const auto& t = detail::kCrcTables.at;
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
    value_ = static_cast<std::uint16_t>(crc);
    for (; left > 0; --left, ++p) update(*p);
    return *this;
  }

  /// Takes one byte in, without a table.
  constexpr Crc16& update(std::uint8_t byte) {
    const unsigned e = detail::crc_entry_key((value_ ^ byte) & 0xFFU);
    value_ = static_cast<std::uint16_t>(value_ >> 8U ^ detail::crc_entry(e));
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
  // update() xors the table entry into the shifted checksum; the entry must exist. Entries are
  // e << 8 ^ e << 3 ^ e >> 4 of a byte e, so their high byte, e ^ e >> 5, tells e.
  const unsigned wanted = received ^ (payload_crc >> 8U);
  const unsigned high = wanted >> 8U;
  const unsigned e = high ^ high >> 5U;
  return (detail::crc_entry(e) & 0xFFFFU) == wanted;
}

}  // namespace cas::mav
