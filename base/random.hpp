// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string_view>

#include "base/export.hpp"

namespace cas::base {

/// A seed derived from a parent seed and a name, so that each plugin of each vehicle has its own
/// stream and adding one changes no other (SplitMix64 over FNV-1a of the name).
CAS_BASE_EXPORT std::uint64_t derive_seed(std::uint64_t parent, std::string_view name);

/// Normal deviates, mean 0, variance 1, the same on every platform: xoshiro256++ with the polar
/// method of Marsaglia. Not for use from several threads.
class CAS_BASE_EXPORT NormalRandom {
 public:
  explicit NormalRandom(std::uint64_t seed = 1);
  /// The next normal deviate.
  double operator()();
  /// Uniform in [0, 1).
  double uniform();
  /// 64 uniform bits.
  std::uint64_t bits();

 private:
  std::uint64_t state_[4];
  double spare_ = 0;
  bool has_spare_ = false;
};

}  // namespace cas::base
