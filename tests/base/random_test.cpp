// SPDX-License-Identifier: BSD-3-Clause
#include "base/random.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <set>

namespace cas::base {
namespace {

constexpr int kSamples = 1'000'000;

TEST(NormalRandom, TheSameSeedGivesTheSameStream) {
  NormalRandom a(42);
  NormalRandom b(42);
  for (int i = 0; i < 1000; ++i) EXPECT_EQ(a(), b());
}

// First words of xoshiro256++ whose state is four words of SplitMix64 from zero; computed apart
// from this code. They fix the stream on every platform.
TEST(NormalRandom, TheWordsAreThoseOfXoshiro256PlusPlus) {
  NormalRandom random(0);
  EXPECT_EQ(random.bits(), 0x53175D61490B23DFU);
  EXPECT_EQ(random.bits(), 0x61DA6F3DC380D507U);
  EXPECT_EQ(random.bits(), 0x5C0FDF91EC9A7BFCU);
}

TEST(NormalRandom, MomentsAreThoseOfTheNormalDistribution) {
  NormalRandom random(7);
  double sum = 0;
  double sum2 = 0;
  double sum4 = 0;
  for (int i = 0; i < kSamples; ++i) {
    const double x = random();
    sum += x;
    sum2 += x * x;
    sum4 += x * x * x * x;
  }
  // five deviations of each estimate at a million samples: sqrt(1/N), sqrt(2/N), sqrt(96/N)
  EXPECT_NEAR(sum / kSamples, 0.0, 5e-3);
  EXPECT_NEAR(sum2 / kSamples, 1.0, 7.1e-3);
  EXPECT_NEAR(sum4 / kSamples, 3.0, 4.9e-2);
}

TEST(NormalRandom, NeighboursAreNotCorrelated) {
  NormalRandom random(11);
  double product = 0;
  double last = random();
  for (int i = 0; i < kSamples; ++i) {
    const double next = random();
    product += last * next;
    last = next;
  }
  EXPECT_NEAR(product / kSamples, 0.0, 5e-3);
}

TEST(NormalRandom, UniformLiesInTheHalfOpenInterval) {
  NormalRandom random(3);
  double sum = 0;
  for (int i = 0; i < kSamples; ++i) {
    const double u = random.uniform();
    ASSERT_GE(u, 0.0);
    ASSERT_LT(u, 1.0);
    sum += u;
  }
  EXPECT_NEAR(sum / kSamples, 0.5, 5 * std::sqrt(1.0 / 12 / kSamples));
}

TEST(DeriveSeed, NamesAndParentsGiveDistinctSeeds) {
  std::set<std::uint64_t> seeds;
  for (std::uint64_t parent = 0; parent < 100; ++parent) {
    for (const char* name : {"", "imu", "gps", "mui", "vehicle1/imu", "vehicle2/imu"}) {
      seeds.insert(derive_seed(parent, name));
    }
  }
  EXPECT_EQ(seeds.size(), 600U);
}

TEST(DeriveSeed, IsAFunctionOfParentAndNameAlone) {
  EXPECT_EQ(derive_seed(1, "imu"), derive_seed(1, "imu"));
  EXPECT_NE(derive_seed(1, "imu"), derive_seed(2, "imu"));
}

}  // namespace
}  // namespace cas::base
