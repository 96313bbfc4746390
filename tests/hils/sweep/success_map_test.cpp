// SPDX-License-Identifier: BSD-3-Clause
#include "hils/sweep/success_map.hpp"

#include <gtest/gtest.h>

#include <optional>
#include <string>
#include <vector>

namespace cas::hils {
namespace {

TEST(Bins, AreTheValuesInTheirOrder) {
  const Bins bins = Bins::of("a", {"10", "9", "10", "-1"}, false);
  EXPECT_EQ(bins.labels, (std::vector<std::string>{"-1", "9", "10"}));
  EXPECT_EQ(bins.bin_of, (std::vector<std::size_t>{2, 1, 2, 0}));
  EXPECT_EQ(Bins::of("a", {"rtk", "9", "ideal"}, false).labels,
            (std::vector<std::string>{"rtk", "9", "ideal"}));
}

TEST(Bins, ManyValuesShareThem) {
  std::vector<std::string> values;
  for (int i = 0; i <= 100; ++i) values.push_back(std::to_string(i));
  const Bins bins = Bins::of("a", values, false, 4);
  EXPECT_EQ(bins.labels, (std::vector<std::string>{"0..25", "25..50", "50..75", "75..100"}));
  EXPECT_EQ(bins.bin_of[24], 0U);
  EXPECT_EQ(bins.bin_of[25], 1U);
  EXPECT_EQ(bins.bin_of[100], 3U);
  const Bins log = Bins::of("a", {"1", "10", "20", "100"}, true, 2);
  EXPECT_EQ(log.labels, (std::vector<std::string>{"1..10", "10..100"}));
  const Bins rounded = Bins::of("a", {"0", "10", "20", "100"}, true, 2);  // 0 has no logarithm
  EXPECT_EQ(rounded.labels, (std::vector<std::string>{"0..50", "50..100"}));
  EXPECT_EQ(rounded.bin_of, (std::vector<std::size_t>{0, 0, 0, 1}));
}

TEST(SuccessMap, CountsCellsAndLeavesOutRunsWithoutAVerdict) {
  const Bins x = Bins::of("x", {"1", "2", "1", "2", "2"}, false);
  const Bins y = Bins::of("y", {"1", "1", "2", "2", "2"}, false);
  const std::vector<std::optional<bool>> up{true, false, true, false, std::nullopt};
  const std::vector<ShareCell> cells = count_by(x, y, up);
  ASSERT_EQ(cells.size(), 4U);
  EXPECT_EQ(cells[0].successes, 1U);
  EXPECT_EQ(cells[1].trials, 1U);
  EXPECT_EQ(cells[3].trials, 1U);
  EXPECT_EQ(cells[3].successes, 0U);
}

/// Six of six are above one half at 95 % (0.5407), five of five are not (0.4782).
TEST(SuccessMap, FramesCellsWhoseIntervalIsAboveOneHalf) {
  EXPECT_EQ((ShareCell{6, 6}.side()), 1);
  EXPECT_EQ((ShareCell{5, 5}.side()), 0);
  EXPECT_EQ((ShareCell{0, 6}.side()), -1);
  const Bins x{.name = "x", .labels = {"1", "2"}, .bin_of = {}};
  const Bins y{.name = "y", .labels = {"1"}, .bin_of = {}};
  const Rows rows = success_map(x, y, {{6, 6}, {5, 5}}).rows;
  ASSERT_EQ(rows.size(), 2U);
  EXPECT_TRUE(rows[1][1].framed);
  EXPECT_EQ(rows[1][1].text, "100");
  EXPECT_FALSE(rows[1][2].framed);
  EXPECT_EQ(rows[1][2].text, "100 ?");
}

}  // namespace
}  // namespace cas::hils
