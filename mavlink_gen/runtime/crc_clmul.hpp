// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#if defined(__x86_64__) && defined(__SSE2__) && defined(__GNUC__)
#define CAS_MAV_CLMUL 1

#include <wmmintrin.h>

#include <cstddef>
#include <cstdint>

namespace cas::mav::detail {

/// Whether this processor multiplies without carries (PCLMULQDQ: Intel since 2010, AMD since 2011).
inline const bool has_clmul = __builtin_cpu_supports("pclmul") != 0;

/// Fewer bytes are not worth a multiplication.
inline constexpr std::size_t kLeastClmulBytes = 8;

// Polynomials over GF(2), bits reflected as in the checksum: the lowest bit has the highest power.
// P = x^16 + x^12 + x^5 + 1.

/// x^power mod P, its lowest power in bit 63.
consteval std::uint64_t power_mod_p(int power) {
  std::uint32_t rest = 1;
  for (int i = 0; i < power; ++i) {
    rest <<= 1U;
    if ((rest & 0x10000U) != 0) rest ^= 0x11021U;
  }
  std::uint64_t reflected = 0;
  for (unsigned i = 0; i < 16; ++i) {
    if ((rest >> i & 1U) != 0) reflected |= std::uint64_t{1} << (63U - i);
  }
  return reflected;
}

/// x^80 / P without its lowest power: x^64 in bit 0, x^1 in bit 63.
consteval std::uint64_t quotient_by_p() {
  std::uint32_t rest = 0;
  std::uint64_t reflected = 0;
  for (int power = 80; power > 0; --power) {
    rest = rest << 1U | (power == 80 ? 1U : 0U);
    if ((rest & 0x10000U) == 0) continue;
    rest ^= 0x11021U;
    reflected |= std::uint64_t{1} << (64 - power);
  }
  return reflected;
}

inline constexpr std::int64_t kP = 0x10811;  ///< x^16 in bit 0
inline constexpr auto kQuotientByP = static_cast<std::int64_t>(quotient_by_p());
// A reflected product stands one bit too low: hence 127 and 191, not 128 and 192.
inline constexpr auto kPast128Bits = static_cast<std::int64_t>(power_mod_p(127));
inline constexpr auto kPast192Bits = static_cast<std::int64_t>(power_mod_p(191));

/// The checksum after one word, into whose first bytes the checksum before it was added: its rest
/// modulo P by two multiplications (P. Barrett, Implementing the RSA Public Key Encryption
/// Algorithm, 1986).
__attribute__((target("pclmul"))) inline __m128i crc_of_word(__m128i word) {
  const __m128i by = _mm_set_epi64x(kP, kQuotientByP);
  const __m128i quotient = _mm_clmulepi64_si128(word, by, 0x00);
  return _mm_srli_si128(_mm_clmulepi64_si128(quotient, by, 0x10), 8);
}

/// CRC-16/MCRF4XX by carry-less multiplication, with four constants instead of tables of 4 KB: a
/// router that sleeps between packets finds no table in the cache.
///
/// Blocks of 16 bytes are folded into the next one (V. Gopal et al., Fast CRC Computation for
/// Generic Polynomials Using PCLMULQDQ Instruction, Intel 2009), the rest goes word by word.
///
/// @param size  at least kLeastClmulBytes
__attribute__((target("pclmul"))) inline std::uint16_t crc_by_clmul(std::uint16_t crc,
                                                                    const std::uint8_t* bytes,
                                                                    std::size_t size) {
  const auto block = [](const std::uint8_t* at) {
    return _mm_loadu_si128(reinterpret_cast<const __m128i*>(at));
  };
  const auto word = [](const std::uint8_t* at) {
    return _mm_loadl_epi64(reinterpret_cast<const __m128i*>(at));
  };
  __m128i sum = _mm_cvtsi32_si128(crc);
  if (size >= 32) {
    const __m128i by = _mm_set_epi64x(kPast128Bits, kPast192Bits);
    __m128i folded = _mm_xor_si128(sum, block(bytes));
    for (bytes += 16, size -= 16; size >= 16; bytes += 16, size -= 16) {
      const __m128i first = _mm_clmulepi64_si128(folded, by, 0x00);
      const __m128i second = _mm_clmulepi64_si128(folded, by, 0x11);
      folded = _mm_xor_si128(_mm_xor_si128(first, second), block(bytes));
    }
    sum = crc_of_word(_mm_xor_si128(crc_of_word(folded), _mm_srli_si128(folded, 8)));
  }
  for (; size >= 8; bytes += 8, size -= 8) sum = crc_of_word(_mm_xor_si128(sum, word(bytes)));
  if (size == 0) return static_cast<std::uint16_t>(_mm_cvtsi128_si64(sum));
  // The last bytes with zeros before them, which change nothing; of one byte the upper half of the
  // checksum remains.
  const auto unused = static_cast<unsigned>(64 - 8 * size);
  const auto last = static_cast<std::uint64_t>(_mm_cvtsi128_si64(word(bytes + size - 8)));
  const auto before = static_cast<std::uint64_t>(_mm_cvtsi128_si64(sum));
  const std::uint64_t tail = (last >> unused ^ before) << unused;
  const __m128i after = crc_of_word(_mm_cvtsi64_si128(static_cast<long long>(tail)));
  const std::uint64_t left = size == 1 ? before >> 8U : 0;
  return static_cast<std::uint16_t>(static_cast<std::uint64_t>(_mm_cvtsi128_si64(after)) ^ left);
}

}  // namespace cas::mav::detail

#endif
