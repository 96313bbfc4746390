// SPDX-License-Identifier: BSD-3-Clause
#include "casd/transport/baud_search.hpp"

#include <gtest/gtest.h>

namespace cas::casd {
namespace {

using std::chrono::milliseconds;

base::RunTime at(base::Duration time) { return base::RunTime(time); }
constexpr base::Duration kListen = BaudSearch::kListen;
constexpr base::Duration kDeaf = BaudSearch::kDeaf;

TEST(BaudSearch, OneRateIsKnownAtOnce) {
  for (const std::vector<unsigned>& rates : {std::vector<unsigned>{}, {57600}}) {
    BaudSearch search(rates);
    search.begin(at({}));
    EXPECT_TRUE(search.found());
    EXPECT_EQ(search.rate(), rates.empty() ? 0 : 57600);
    EXPECT_FALSE(search.advance(at(10 * kListen)));
  }
}

TEST(BaudSearch, GoesRoundUntilPacketsCome) {
  BaudSearch search({1, 2, 3});
  search.begin(at({}));
  EXPECT_EQ(search.rate(), 1U);
  EXPECT_EQ(search.due(), at(kListen));
  EXPECT_FALSE(search.advance(at(kListen - milliseconds(1))));
  base::Duration now{};
  for (const unsigned next : {2U, 3U, 1U, 2U}) {
    now += kListen;
    EXPECT_TRUE(search.advance(at(now)));
    EXPECT_EQ(search.rate(), next);
  }
  EXPECT_TRUE(search.heard(BaudSearch::kEnoughPackets));
  EXPECT_FALSE(search.advance(at(now + 2 * kListen)));
  EXPECT_EQ(search.rate(), 2U);
}

TEST(BaudSearch, OnePacketAtARateMayBeNoise) {
  BaudSearch search({1, 2});
  search.begin(at({}));
  EXPECT_FALSE(search.heard(1));
  EXPECT_TRUE(search.advance(at(kListen)));
  EXPECT_FALSE(search.heard(1)) << "that of the other rate does not count";
  EXPECT_TRUE(search.heard(1));
}

TEST(BaudSearch, BeginsAgainWithTheRateThatWasRight) {
  BaudSearch search({1, 2});
  search.begin(at({}));
  search.advance(at(kListen));
  ASSERT_TRUE(search.heard(2));
  search.begin(at(5 * kListen));
  EXPECT_FALSE(search.found()) << "another device may have another rate";
  EXPECT_EQ(search.rate(), 2U);
  EXPECT_EQ(search.due(), at(6 * kListen));
}

TEST(BaudSearch, BytesWithoutAPacketForLongMeanAnotherRate) {
  BaudSearch search({1, 2});
  search.begin(at({}));
  ASSERT_TRUE(search.heard(2));
  EXPECT_TRUE(search.fits(100, 1, at(kDeaf)));
  EXPECT_TRUE(search.fits(100, 0, at(5 * kDeaf))) << "it was silent, and a packet begins";
  EXPECT_TRUE(search.fits(100, 1, at(5 * kDeaf + milliseconds(1))));
  for (base::Duration now = 6 * kDeaf; now <= 7 * kDeaf; now += milliseconds(100)) {
    EXPECT_TRUE(search.fits(100, 0, at(now)));
  }
  EXPECT_FALSE(search.fits(100, 0, at(7 * kDeaf + milliseconds(1))));
  search.begin(at(8 * kDeaf));
  EXPECT_TRUE(search.fits(1, 0, at(20 * kDeaf))) << "what came before counts no more";
}

TEST(BaudSearch, TheOnlyRateFitsWhateverComes) {
  BaudSearch search({1});
  search.begin(at({}));
  for (int i = 0; i < 100; ++i) EXPECT_TRUE(search.fits(1000, 0, at(i * kDeaf)));
}

}  // namespace
}  // namespace cas::casd
