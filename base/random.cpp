// SPDX-License-Identifier: BSD-3-Clause
#include "base/random.hpp"

#include <bit>
#include <cmath>

namespace cas::base {
namespace {

/// SplitMix64 (Steele, Lea, Flood 2014): advances `state` and returns the next word.
std::uint64_t split_mix(std::uint64_t& state) {
  state += 0x9E3779B97F4A7C15U;
  std::uint64_t z = state;
  z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9U;
  z = (z ^ (z >> 27)) * 0x94D049BB133111EBU;
  return z ^ (z >> 31);
}

/// 64-bit FNV-1a.
std::uint64_t hash(std::string_view text) {
  std::uint64_t h = 0xCBF29CE484222325U;
  for (const char c : text) {
    h ^= static_cast<unsigned char>(c);
    h *= 0x100000001B3U;
  }
  return h;
}

}  // namespace

std::uint64_t derive_seed(std::uint64_t parent, std::string_view name) {
  std::uint64_t state = parent;
  state = split_mix(state) ^ hash(name);
  return split_mix(state);
}

NormalRandom::NormalRandom(std::uint64_t seed) {
  for (std::uint64_t& word : state_) word = split_mix(seed);
}

// xoshiro256++ 1.0 (Blackman, Vigna 2019).
std::uint64_t NormalRandom::bits() {
  const std::uint64_t result = std::rotl(state_[0] + state_[3], 23) + state_[0];
  const std::uint64_t t = state_[1] << 17;
  state_[2] ^= state_[0];
  state_[3] ^= state_[1];
  state_[1] ^= state_[2];
  state_[0] ^= state_[3];
  state_[2] ^= t;
  state_[3] = std::rotl(state_[3], 45);
  return result;
}

double NormalRandom::uniform() {
  return static_cast<double>(bits() >> 11) * 0x1.0p-53;  // 53 bits: every double of the grid
}

double NormalRandom::operator()() {
  if (has_spare_) {
    has_spare_ = false;
    return spare_;
  }
  double u = 0;
  double v = 0;
  double s = 0;
  do {
    u = 2.0 * uniform() - 1.0;
    v = 2.0 * uniform() - 1.0;
    s = u * u + v * v;
  } while (s >= 1.0 || s == 0.0);
  const double scale = std::sqrt(-2.0 * std::log(s) / s);
  spare_ = v * scale;
  has_spare_ = true;
  return u * scale;
}

}  // namespace cas::base
