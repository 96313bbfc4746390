// SPDX-License-Identifier: BSD-3-Clause
#include "base/measure/histogram.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "base/random.hpp"

namespace cas::base {
namespace {

using namespace std::chrono_literals;

constexpr double kBucketError = 0.032;  // a thirty-second of an octave

TEST(Histogram, AnEmptyOneSaysZero) {
  const Histogram histogram;
  EXPECT_EQ(histogram.count(), 0U);
  EXPECT_EQ(histogram.mean(), 0ns);
  EXPECT_EQ(histogram.quantile(0.5), 0ns);
}

TEST(Histogram, CountMeanAndMaximumAreExact) {
  Histogram histogram;
  for (const Duration value : {1us, 2us, 6us}) histogram.add(value);
  EXPECT_EQ(histogram.count(), 3U);
  EXPECT_EQ(histogram.mean(), 3us);
  EXPECT_EQ(histogram.max(), 6us);
  EXPECT_EQ(histogram.quantile(1.0), 6us);
}

TEST(Histogram, OctavesHoldEveryEntryOnce) {
  Histogram histogram;
  for (const Duration value : {0ns, 1ns, 1000ns, 1023ns, 1024ns, 1024ns}) histogram.add(value);
  const auto bins = histogram.octaves();
  ASSERT_EQ(bins.size(), 3U);
  EXPECT_EQ(bins[0].upper, 2ns);
  EXPECT_EQ(bins[0].count, 2U);
  EXPECT_EQ(bins[1].upper, 1024ns);
  EXPECT_EQ(bins[1].count, 2U);
  EXPECT_EQ(bins[2].upper, 2048ns);
  EXPECT_EQ(bins[2].count, 2U);
}

TEST(Histogram, EachSizeOfValueIsKeptWithinTheBucketError) {
  for (std::int64_t ns = 1; ns < 1'100'000'000'000; ns = ns * 17 / 16 + 1) {
    Histogram histogram;
    histogram.add(Duration(ns));
    histogram.add(Duration(ns));
    histogram.add(2000s);  // keeps the maximum from bounding the answer
    const auto median = static_cast<double>(histogram.quantile(0.5).count());
    EXPECT_NEAR(median, static_cast<double>(ns), kBucketError * static_cast<double>(ns)) << ns;
  }
}

TEST(Histogram, QuantilesMatchASortedList) {
  NormalRandom random(5);
  Histogram histogram;
  std::vector<std::int64_t> values;
  for (int i = 0; i < 20'000; ++i) {
    values.push_back(static_cast<std::int64_t>(1e6 * std::exp(random())));
    histogram.add(Duration(values.back()));
  }
  std::sort(values.begin(), values.end());
  for (const double q : {0.01, 0.5, 0.9, 0.99, 0.999}) {
    const auto rank = static_cast<std::size_t>(std::ceil(q * 20'000)) - 1;
    const auto exact = static_cast<double>(values[rank]);
    EXPECT_NEAR(static_cast<double>(histogram.quantile(q).count()), exact, kBucketError * exact);
  }
}

TEST(Histogram, ValuesOutsideTheRangeAreCountedAtItsEnds) {
  Histogram histogram;
  histogram.add(-5ns);
  histogram.add(0ns);
  histogram.add(24h);
  EXPECT_EQ(histogram.count(), 3U);
  EXPECT_EQ(histogram.max(), 24h);
  EXPECT_LE(histogram.quantile(0.5), 1ns);
}

TEST(Histogram, MergingEqualsAddingBoth) {
  Histogram a;
  Histogram b;
  Histogram both;
  for (int i = 1; i <= 100; ++i) {
    (i % 2 == 0 ? a : b).add(i * 1ms);
    both.add(i * 1ms);
  }
  a.merge(b);
  EXPECT_EQ(a.count(), both.count());
  EXPECT_EQ(a.mean(), both.mean());
  EXPECT_EQ(a.max(), both.max());
  EXPECT_EQ(a.quantile(0.3), both.quantile(0.3));
  a.clear();
  EXPECT_EQ(a.count(), 0U);
}

}  // namespace
}  // namespace cas::base
