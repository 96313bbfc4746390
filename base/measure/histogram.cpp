// SPDX-License-Identifier: BSD-3-Clause
#include "base/measure/histogram.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <numeric>

namespace cas::base {
namespace {

constexpr int kBucketsPerOctave = 32;
constexpr int kBucketBits = 5;
constexpr int kOctaves = 41;

// A value 2^octave * (1 + sub/32) lies in bucket octave * 32 + sub.
int bucket_of(std::int64_t ns) {
  const auto value = static_cast<std::uint64_t>(
      std::clamp<std::int64_t>(ns, 1, (std::int64_t{1} << kOctaves) - 1));
  const int octave = static_cast<int>(std::bit_width(value)) - 1;
  const auto sub = static_cast<int>((value << kBucketBits) >> octave) - kBucketsPerOctave;
  return octave * kBucketsPerOctave + sub;
}

std::int64_t lower_edge(int bucket) {
  const int octave = bucket / kBucketsPerOctave;
  const std::int64_t mantissa = kBucketsPerOctave + bucket % kBucketsPerOctave;
  return (mantissa << octave) >> kBucketBits;
}

std::int64_t middle(int bucket) {
  const std::int64_t low = lower_edge(bucket);
  const std::int64_t high = std::max(low, lower_edge(bucket + 1) - 1);
  return low + (high - low) / 2;
}

}  // namespace

void Histogram::add(Duration value) {
  value = std::max(value, Duration::zero());
  ++buckets_[static_cast<std::size_t>(bucket_of(value.count()))];
  ++count_;
  sum_ += value;
  max_ = std::max(max_, value);
}

void Histogram::merge(const Histogram& other) {
  for (std::size_t i = 0; i < buckets_.size(); ++i) buckets_[i] += other.buckets_[i];
  count_ += other.count_;
  sum_ += other.sum_;
  max_ = std::max(max_, other.max_);
}

void Histogram::clear() { *this = Histogram(); }

Duration Histogram::mean() const {
  return count_ == 0 ? Duration::zero() : sum_ / static_cast<Duration::rep>(count_);
}

Duration Histogram::quantile(double q) const {
  if (count_ == 0) return Duration::zero();
  const double wanted = std::ceil(std::clamp(q, 0.0, 1.0) * static_cast<double>(count_));
  const auto rank = std::max<std::uint64_t>(1, static_cast<std::uint64_t>(wanted));
  if (rank >= count_) return max_;
  std::uint64_t seen = 0;
  for (std::size_t i = 0; i < buckets_.size(); ++i) {
    seen += buckets_[i];
    if (seen >= rank) return std::min(Duration(middle(static_cast<int>(i))), max_);
  }
  return max_;
}

std::vector<Histogram::Bin> Histogram::octaves() const {
  std::vector<Bin> bins;
  for (int octave = 0; octave < kOctaves; ++octave) {
    const auto first = buckets_.begin() + octave * kBucketsPerOctave;
    const std::uint64_t count = std::accumulate(first, first + kBucketsPerOctave, std::uint64_t{0});
    if (count > 0) bins.push_back({Duration(std::int64_t{1} << (octave + 1)), count});
  }
  return bins;
}

}  // namespace cas::base
