// SPDX-License-Identifier: BSD-3-Clause
#include "hils/report/plot.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <regex>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

namespace cas::hils {
namespace {

using Points = std::vector<std::pair<double, double>>;

/// Corners of the first curve, px. (Long paths are too much for std::regex.)
Points first_curve(const std::string& svg) {
  const std::size_t style = svg.find("\" fill=\"none\" stroke-width=\"1.4\"");
  if (style == std::string::npos) return {};
  const std::size_t path = svg.rfind("d=\"", style) + 3;
  std::string corners = svg.substr(path, style - path);
  std::ranges::replace_if(
      corners, [](char c) { return c == 'M' || c == 'L'; }, ' ');
  std::istringstream in(corners);
  Points points;
  for (double x = 0, y = 0; in >> x >> y;) points.emplace_back(x, y);
  return points;
}

/// A text of the plot with its place, px.
struct Text {
  double x = 0;
  double y = 0;
};

Text place_of(const std::string& svg, const std::string& text) {
  std::smatch place;
  const std::regex element("<text x=\"([-0-9.]+)\" y=\"([-0-9.]+)\"[^>]*>" + text + "</text>");
  if (!std::regex_search(svg, place, element)) return {-1, -1};
  return {std::stod(place[1]), std::stod(place[2])};
}

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

/// Width and height of the first curve, px.
std::pair<double, double> extent_of(const Points& points) {
  const auto [left, right] = std::ranges::minmax(points, {}, &Points::value_type::first);
  const auto [high, low] = std::ranges::minmax(points, {}, &Points::value_type::second);
  return {right.first - left.first, low.second - high.second};
}

TEST(Plot, DrawsACircleRoundWhereScalesAreEqual) {
  Series circle{.name = "truth"};
  for (int i = 0; i <= 7200; ++i) {
    const double angle = i * std::numbers::pi / 3600;
    circle.points.emplace_back(30 + 2 * std::sin(angle), 5 + 2 * std::cos(angle));
  }
  const Series far_east{.points = {{30, 5}, {50, 5}}};
  const Series far_north{.points = {{30, 5}, {30, 25}}};
  for (const Series& other : {Series{}, far_east, far_north}) {
    const Points points = first_curve(to_svg({.series = {circle, other}, .equal_scales = true}));
    ASSERT_GT(points.size(), 50U);
    const auto [width, height] = extent_of(points);
    EXPECT_NEAR(width, height, 0.5);
    EXPECT_GT(width, other.points.empty() ? 300 : 50);  // alone it fills the shorter side
    for (std::size_t i = 1; i < points.size(); ++i) {   // all the way round
      EXPECT_LT(std::hypot(points[i].first - points[i - 1].first,
                           points[i].second - points[i - 1].second),
                2);
    }
  }
}

TEST(Plot, KeepsTextsOfMarksOffTheCurvesAndOffEachOther) {
  Plot plot{.series = {{.name = "truth", .points = {{0, 0}, {50, 1}, {100, 1}}}}};
  plot.marks = {{.x = 20, .text = "takeoff"}, {.x = 21, .text = "hold"}, {.x = 60, .text = "land"}};
  const std::string svg = to_svg(plot);
  const Text takeoff = place_of(svg, "takeoff");
  const Text hold = place_of(svg, "hold");
  const Text land = place_of(svg, "land");
  EXPECT_GE(hold.y - takeoff.y, 10);  // a row below
  EXPECT_EQ(land.y, takeoff.y);       // there is room in the first
  double highest = std::numeric_limits<double>::infinity();
  for (const auto& [x, y] : first_curve(svg)) highest = std::min(highest, y);
  EXPECT_LT(std::max({takeoff.y, hold.y, land.y}), highest);
}

TEST(Plot, MovesATextThatTheEdgeWouldClip) {
  Plot plot{.series = {{.name = "truth", .points = {{0, 0}, {100, 1}}}}};
  plot.marks = {{.x = 99.9, .text = "a rather long phase"}};
  constexpr double kCharacter_px = 7.2;  // on a narrow page
  constexpr double kWidth_px = 720;
  const Text text = place_of(to_svg(plot), plot.marks.front().text);
  ASSERT_GE(text.x, 0);
  EXPECT_LE(text.x + kCharacter_px * static_cast<double>(plot.marks.front().text.size()),
            kWidth_px);
}

TEST(Plot, BreaksALegendBeforeTheRightEdge) {
  Plot plot;
  for (int i = 0; i < 9; ++i) {
    plot.series.push_back(
        {.name = "variant 46080" + std::to_string(i), .points = {{0, 0}, {1, i}}});
  }
  const std::string svg = to_svg(plot);
  EXPECT_GT(place_of(svg, "variant 460808").y, place_of(svg, "variant 460800").y);
  for (const Series& series : plot.series) EXPECT_LT(place_of(svg, series.name).x, 640) << svg;
}

TEST(Plot, LabelsNoTickMinusZero) {
  const std::string svg = to_svg({.series = {{.points = {{-0.1, -0.01}, {10, 1}}}}});
  EXPECT_NE(svg.find(">0<"), std::string::npos);
  EXPECT_EQ(svg.find(">-0<"), std::string::npos);
}

TEST(Plot, HasDecadesOnALogarithmicAxis) {
  const std::string svg =
      to_svg({.series = {{.points = {{1, 0}, {2, 0.01}, {3, 100}}}}, .log_y = true});
  EXPECT_NE(svg.find(">0.1<"), std::string::npos);
  EXPECT_NE(svg.find(">100<"), std::string::npos);
  EXPECT_EQ(svg.find("inf"), std::string::npos);
  EXPECT_EQ(first_curve(svg).size(), 2U);  // zero has no place there
}

TEST(Plot, HasColoursForReadersWhoPreferTheDark) {
  const std::string svg = to_svg({.series = {{.name = "truth", .points = {{0, 0}, {1, 1}}}}});
  EXPECT_NE(svg.find("prefers-color-scheme:dark"), std::string::npos);
  EXPECT_NE(svg.find("class=\"c0\""), std::string::npos);
}

TEST(Plot, DrawsDotsWithoutALine) {
  const std::string svg = to_svg({.series = {{.points = {{0, 0}, {1, 1}}, .dots = true}}});
  EXPECT_NE(svg.find("stroke-linecap=\"round\""), std::string::npos) << svg;
  EXPECT_EQ(std::count(svg.begin(), svg.end(), 'L'), 0) << svg;
}

}  // namespace
}  // namespace cas::hils
