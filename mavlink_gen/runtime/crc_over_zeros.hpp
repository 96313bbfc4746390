// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>

/// Moves a checksum along a stream, for receivers; who only sends does not have the compiler make
/// the table.
namespace cas::mav {
namespace detail {

inline constexpr std::uint16_t kReflectedPolynomial = 0x8408;  // 0x1021 with its bits mirrored

/// Most bytes that a packet's checksum takes in: header without the start byte, payload.
inline constexpr std::size_t kMaxChecksummedBytes = 9 + 255;

/// Element m is what becomes of the checksum's highest bit after m zero bits.
struct CrcShifts {
  std::uint16_t at[8 * kMaxChecksummedBytes + 16];
};

constexpr CrcShifts make_crc_shifts() {
  CrcShifts shifts{};
  unsigned crc = 0x8000;
  for (auto& shift : shifts.at) {
    shift = static_cast<std::uint16_t>(crc);
    crc = (crc & 1U) != 0 ? (crc >> 1U) ^ kReflectedPolynomial : crc >> 1U;
  }
  return shifts;
}

inline constexpr CrcShifts kCrcShifts = make_crc_shifts();

/// Element n has all bits of those of its four lanes that are set in n, highest bit first.
using CrcLaneMasks = std::array<std::array<std::uint16_t, 4>, 16>;

constexpr CrcLaneMasks make_crc_lane_masks() {
  CrcLaneMasks masks{};
  for (unsigned n = 0; n < 16; ++n) {
    for (unsigned lane = 0; lane < 4; ++lane) {
      if ((n >> (3U - lane) & 1U) != 0) masks[n][lane] = 0xFFFF;
    }
  }
  return masks;
}

inline constexpr CrcLaneMasks kCrcLaneMasks = make_crc_lane_masks();

}  // namespace detail

/// What `crc` becomes over that many zero bytes, at most detail::kMaxChecksummedBytes.
///
/// The checksum is linear, so this moves one along a stream: with c(i) the running checksum of the
/// first i bytes from any start, the checksum of bytes i to j is c(j) ^ crc_over_zeros(c(i) ^
/// 0xFFFF, j - i).
inline std::uint16_t crc_over_zeros(std::uint16_t crc, std::size_t bytes) {
  // Each set bit brings one element of kCrcShifts; four are added at once.
  const auto* shifts = detail::kCrcShifts.at + 8 * bytes;
  std::uint64_t sum = 0;
  for (unsigned group = 0; group < 4; ++group) {
    std::uint64_t elements;
    std::uint64_t mask;
    std::memcpy(&elements, shifts + std::size_t{4} * group, sizeof elements);
    std::memcpy(&mask, detail::kCrcLaneMasks[crc >> (12U - 4U * group) & 0xFU].data(), sizeof mask);
    sum ^= elements & mask;
  }
  sum ^= sum >> 32U;
  return static_cast<std::uint16_t>(sum ^ sum >> 16U);
}

}  // namespace cas::mav
