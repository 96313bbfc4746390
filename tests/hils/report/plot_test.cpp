// SPDX-License-Identifier: BSD-3-Clause
#include "hils/report/plot.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <string>

namespace cas::hils {
namespace {

TEST(Plot, IsOneSvgElementWithItsWords) {
  const std::string svg = to_svg({.title = "a < b",
                                  .x_label = "time",
                                  .y_label = "m",
                                  .series = {{.name = "truth", .points = {{0, 1}, {1, 2}}}},
                                  .marks = {{.x = 0.5, .text = "fault"}}});
  EXPECT_EQ(svg.rfind("<svg", 0), 0U);
  EXPECT_NE(svg.find("a &lt; b"), std::string::npos);
  EXPECT_NE(svg.find("truth"), std::string::npos);
  EXPECT_NE(svg.find("fault"), std::string::npos);
  EXPECT_EQ(svg.find("nan"), std::string::npos);
}

TEST(Plot, ThinsLongCurvesButKeepsTheirExtremes) {
  Series series;
  for (int i = 0; i < 100'000; ++i) series.points.emplace_back(i, i == 77'777 ? 100 : 0);
  const std::string svg = to_svg({.series = {series}});
  EXPECT_LT(svg.size(), 80'000U);
  EXPECT_NE(svg.find("100<"), std::string::npos);  // the axis reaches the peak
}

TEST(Plot, DrawsNothingWithoutValues) {
  const std::string svg = to_svg(
      {.series = {{.name = "x", .points = {{0, std::numeric_limits<double>::quiet_NaN()}}}, {}}});
  EXPECT_EQ(svg.find("nan"), std::string::npos);
  EXPECT_EQ(svg.find("inf"), std::string::npos);
}

}  // namespace
}  // namespace cas::hils
