// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>

#if defined(__x86_64__) || defined(__i386__)
#include <cpuid.h>
#include <immintrin.h>
#define CAS_SHA_INSTRUCTIONS 1
#else
#define CAS_SHA_INSTRUCTIONS 0
#endif

/// SHA-256 [FIPS 180-4], portable and with the CPU's own instructions.
namespace cas::mav {

inline constexpr std::size_t kSha256Bytes = 32;
inline constexpr std::size_t kSha256BlockBytes = 64;
using Sha256Digest = std::array<std::uint8_t, kSha256Bytes>;
using Sha256State = std::array<std::uint32_t, 8>;

namespace detail {

/// First 32 bits of the fractional parts of the cube roots of the first 64 primes.
alignas(16) inline constexpr std::array<std::uint32_t, 64> kSha256Constants{
    0x428a2f98, 0x71374491, 0xb5c0fbcf, 0xe9b5dba5, 0x3956c25b, 0x59f111f1, 0x923f82a4, 0xab1c5ed5,
    0xd807aa98, 0x12835b01, 0x243185be, 0x550c7dc3, 0x72be5d74, 0x80deb1fe, 0x9bdc06a7, 0xc19bf174,
    0xe49b69c1, 0xefbe4786, 0x0fc19dc6, 0x240ca1cc, 0x2de92c6f, 0x4a7484aa, 0x5cb0a9dc, 0x76f988da,
    0x983e5152, 0xa831c66d, 0xb00327c8, 0xbf597fc7, 0xc6e00bf3, 0xd5a79147, 0x06ca6351, 0x14292967,
    0x27b70a85, 0x2e1b2138, 0x4d2c6dfc, 0x53380d13, 0x650a7354, 0x766a0abb, 0x81c2c92e, 0x92722c85,
    0xa2bfe8a1, 0xa81a664b, 0xc24b8b70, 0xc76c51a3, 0xd192e819, 0xd6990624, 0xf40e3585, 0x106aa070,
    0x19a4c116, 0x1e376c08, 0x2748774c, 0x34b0bcb5, 0x391c0cb3, 0x4ed8aa4a, 0x5b9cca4f, 0x682e6ff3,
    0x748f82ee, 0x78a5636f, 0x84c87814, 0x8cc70208, 0x90befffa, 0xa4506ceb, 0xbef9a3f7, 0xc67178f2};

/// First 32 bits of the fractional parts of the square roots of the first 8 primes.
inline constexpr Sha256State kSha256Start{0x6a09e667, 0xbb67ae85, 0x3c6ef372, 0xa54ff53a,
                                          0x510e527f, 0x9b05688c, 0x1f83d9ab, 0x5be0cd19};

inline std::uint32_t load_big_endian(const std::uint8_t* p) {
  return static_cast<std::uint32_t>(p[0]) << 24U | static_cast<std::uint32_t>(p[1]) << 16U |
         static_cast<std::uint32_t>(p[2]) << 8U | p[3];
}

}  // namespace detail

/// One block after the other in plain C++.
struct Sha256Portable {
  static void compress(Sha256State& state, const std::uint8_t* data, std::size_t blocks) {
    for (; blocks > 0; --blocks, data += kSha256BlockBytes) compress_block(state, data);
  }

 private:
  static void compress_block(Sha256State& state, const std::uint8_t* data) {
    std::array<std::uint32_t, 64> w;
    for (std::size_t t = 0; t < 16; ++t) w[t] = detail::load_big_endian(data + 4 * t);
    for (std::size_t t = 16; t < 64; ++t) {
      const auto s0 = std::rotr(w[t - 15], 7) ^ std::rotr(w[t - 15], 18) ^ (w[t - 15] >> 3U);
      const auto s1 = std::rotr(w[t - 2], 17) ^ std::rotr(w[t - 2], 19) ^ (w[t - 2] >> 10U);
      w[t] = w[t - 16] + s0 + w[t - 7] + s1;
    }
    auto [a, b, c, d, e, f, g, h] = state;
    for (std::size_t t = 0; t < 64; ++t) {
      const auto sum1 = std::rotr(e, 6) ^ std::rotr(e, 11) ^ std::rotr(e, 25);
      const auto choice = (e & f) ^ (~e & g);
      const auto t1 = h + sum1 + choice + detail::kSha256Constants[t] + w[t];
      const auto sum0 = std::rotr(a, 2) ^ std::rotr(a, 13) ^ std::rotr(a, 22);
      const auto majority = (a & b) ^ (a & c) ^ (b & c);
      h = g;
      g = f;
      f = e;
      e = d + t1;
      d = c;
      c = b;
      b = a;
      a = t1 + sum0 + majority;
    }
    const Sha256State add{a, b, c, d, e, f, g, h};
    for (std::size_t i = 0; i < state.size(); ++i) state[i] += add[i];
  }
};

#if CAS_SHA_INSTRUCTIONS

/// The SHA extensions of x86 processors. Call only where available() says so.
struct Sha256Instructions {
  static bool available() {
    unsigned a{}, b{}, c{}, d{};
    constexpr unsigned kSsse3 = 1U << 9U, kSse41 = 1U << 19U, kSha = 1U << 29U;
    if (__get_cpuid(1, &a, &b, &c, &d) == 0 || (c & kSsse3) == 0 || (c & kSse41) == 0) return false;
    return __get_cpuid_count(7, 0, &a, &b, &c, &d) != 0 && (b & kSha) != 0;
  }

  __attribute__((target("sha,sse4.1,ssse3"))) static void compress(Sha256State& state,
                                                                   const std::uint8_t* data,
                                                                   std::size_t blocks) {
    // The instructions want the eight words as (a b e f) and (c d g h), first word highest.
    const auto lane = [&](std::size_t i) { return static_cast<int>(state[i]); };
    auto abef = _mm_set_epi32(lane(0), lane(1), lane(4), lane(5));
    auto cdgh = _mm_set_epi32(lane(2), lane(3), lane(6), lane(7));
    const auto big_endian = _mm_set_epi64x(0x0c0d0e0f08090a0b, 0x0405060700010203);
    for (; blocks > 0; --blocks, data += kSha256BlockBytes) {
      const auto abef_before = abef;
      const auto cdgh_before = cdgh;
      __m128i w[4];  // the last 16 words of the message schedule, as a ring
#pragma GCC unroll 16
      for (int i = 0; i < 16; ++i) {
        auto& now = w[i & 3];
        if (i < 4) {
          now = _mm_shuffle_epi8(_mm_loadu_si128(reinterpret_cast<const __m128i*>(data) + i),
                                 big_endian);
        } else {
          const auto& last = w[(i + 3) & 3];
          const auto middle = _mm_alignr_epi8(last, w[(i + 2) & 3], 4);
          now = _mm_sha256msg2_epu32(
              _mm_add_epi32(_mm_sha256msg1_epu32(now, w[(i + 1) & 3]), middle), last);
        }
        const auto* constants =
            reinterpret_cast<const __m128i*>(detail::kSha256Constants.data()) + i;
        const auto sum = _mm_add_epi32(now, _mm_load_si128(constants));
        // Two rounds turn (a b e f) into the new (c d g h) and back: the names swap twice.
        cdgh = _mm_sha256rnds2_epu32(cdgh, abef, sum);
        abef = _mm_sha256rnds2_epu32(abef, cdgh, _mm_shuffle_epi32(sum, 0x0E));
      }
      abef = _mm_add_epi32(abef, abef_before);
      cdgh = _mm_add_epi32(cdgh, cdgh_before);
    }
    const auto word = [](int value) { return static_cast<std::uint32_t>(value); };
    state = {word(_mm_extract_epi32(abef, 3)), word(_mm_extract_epi32(abef, 2)),
             word(_mm_extract_epi32(cdgh, 3)), word(_mm_extract_epi32(cdgh, 2)),
             word(_mm_extract_epi32(abef, 1)), word(_mm_extract_epi32(abef, 0)),
             word(_mm_extract_epi32(cdgh, 1)), word(_mm_extract_epi32(cdgh, 0))};
  }
};

#endif

/// The instructions where the running CPU has them, else plain C++.
struct Sha256Fastest {
  static void compress(Sha256State& state, const std::uint8_t* data, std::size_t blocks) {
#if CAS_SHA_INSTRUCTIONS
    if (has_instructions_) return Sha256Instructions::compress(state, data, blocks);
#endif
    Sha256Portable::compress(state, data, blocks);
  }

 private:
#if CAS_SHA_INSTRUCTIONS
  inline static const bool has_instructions_ = Sha256Instructions::available();
#endif
};

/// SHA-256 over bytes that come in pieces. `Compression` is one of the structs above.
template <class Compression>
class BasicSha256 {
 public:
  BasicSha256& update(std::span<const std::uint8_t> bytes) {
    total_ += bytes.size();
    if (held_ > 0) bytes = fill(bytes);
    if (const auto blocks = bytes.size() / kSha256BlockBytes; blocks > 0) {
      Compression::compress(state_, bytes.data(), blocks);
      bytes = bytes.subspan(blocks * kSha256BlockBytes);
    }
    fill(bytes);
    return *this;
  }

  /// Ends the message; the object is used up.
  Sha256Digest finish() {
    constexpr std::size_t kLengthAt = kSha256BlockBytes - 8;
    block_[held_++] = 0x80;
    if (held_ > kLengthAt) {
      std::memset(block_.data() + held_, 0, block_.size() - held_);
      Compression::compress(state_, block_.data(), 1);
      held_ = 0;
    }
    std::memset(block_.data() + held_, 0, kLengthAt - held_);
    const auto bits = static_cast<std::uint64_t>(total_) * 8;
    for (std::size_t i = 0; i < 8; ++i) {
      block_[kLengthAt + i] = static_cast<std::uint8_t>(bits >> (56 - 8 * i));
    }
    Compression::compress(state_, block_.data(), 1);
    Sha256Digest digest;
    for (std::size_t i = 0; i < digest.size(); ++i) {
      digest[i] = static_cast<std::uint8_t>(state_[i / 4] >> (24 - 8 * (i % 4)));
    }
    return digest;
  }

 private:
  /// Moves bytes into the open block and compresses it when full; returns the bytes left over.
  std::span<const std::uint8_t> fill(std::span<const std::uint8_t> bytes) {
    const auto room = kSha256BlockBytes - held_;
    const auto taken = bytes.size() < room ? bytes.size() : room;
    if (taken == 0) return bytes;
    std::memcpy(block_.data() + held_, bytes.data(), taken);
    held_ += taken;
    if (held_ == kSha256BlockBytes) {
      Compression::compress(state_, block_.data(), 1);
      held_ = 0;
    }
    return bytes.subspan(taken);
  }

  Sha256State state_{detail::kSha256Start};
  std::size_t total_{};
  std::size_t held_{};
  std::array<std::uint8_t, kSha256BlockBytes> block_;  // only its first held_ bytes count
};

using Sha256 = BasicSha256<Sha256Fastest>;

}  // namespace cas::mav
