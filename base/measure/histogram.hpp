// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "base/export.hpp"
#include "base/time/clock.hpp"

namespace cas::base {

/// Counts durations in logarithmic buckets (32 per octave, error below 3.2 %) from 1 ns to 1100 s.
/// Fixed size, no allocation, one writer.
class CAS_BASE_EXPORT Histogram {
 public:
  void add(Duration value);
  void merge(const Histogram& other);
  void clear();

  std::uint64_t count() const { return count_; }
  /// The largest entry, exact; 0 without entries.
  Duration max() const { return max_; }
  /// The mean of the entries, exact; 0 without entries.
  Duration mean() const;
  /// Value below which the fraction `q` (0..1) of the entries lies; 0 without entries.
  Duration quantile(double q) const;

  /// Entries below `upper` and not below that of the bin before.
  struct Bin {
    Duration upper;
    std::uint64_t count = 0;
  };
  /// The whole distribution, one bin per octave (upper ends are powers of two in ns), without empty
  /// bins.
  std::vector<Bin> octaves() const;

 private:
  static constexpr int kBuckets = 41 * 32;
  std::array<std::uint64_t, kBuckets> buckets_{};
  std::uint64_t count_ = 0;
  Duration sum_{};
  Duration max_{};
};

}  // namespace cas::base
