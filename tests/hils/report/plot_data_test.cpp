// SPDX-License-Identifier: BSD-3-Clause
#include "hils/report/plot_data.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "hils/report/document.hpp"
#include "tests/support/temporary_folder.hpp"

namespace cas::hils {
namespace {

/// With a page that has this script.
class PlotData : public testing::Test {
 protected:
  PlotData() {
    folder_.write("index.html", "");
    folder_.write("report.js", "draw();");
    folder_.write("report.css", "p{}");
    ::setenv("CAS_WEB_PATH", folder_.path().c_str(), 1);
  }
  ~PlotData() override { ::unsetenv("CAS_WEB_PATH"); }

  static nlohmann::json data_of(const Plot& plot) {
    const std::string block = plot_block(plot);
    const std::size_t begin = block.find('>') + 1;
    return nlohmann::json::parse(block.substr(begin, block.rfind('<') - begin));
  }
  static std::vector<double> values(const nlohmann::json& column) {
    std::vector<double> values;
    double sum = 0;
    for (const double difference : column.at("d")) {
      values.push_back((sum += difference) * column.at("k").get<double>());
    }
    return values;
  }

  cas::test::TemporaryFolder folder_;
};

TEST_F(PlotData, HasTheCurveAsFinelyAsAZoomShowsIt) {
  Plot plot{.x_label = "simulated time, s", .y_label = "north, m"};
  plot.series.push_back({.name = "truth"});
  for (int i = 0; i < 60'000; ++i) {
    plot.series[0].points.emplace_back(1e-3 * i, i == 31'415 ? 9.0 : std::sin(1e-3 * i));
  }
  const auto data = data_of(plot);
  const auto x = values(data["series"][0]["x"]);
  const auto y = values(data["series"][0]["y"]);
  ASSERT_EQ(x.size(), y.size());
  EXPECT_LE(x.size(), 3000U);
  EXPECT_EQ(*std::ranges::max_element(y), 9.0) << "no peak is thinned away";
  for (std::size_t i = 0; i < x.size(); ++i) {
    if (y[i] < 2) {
      EXPECT_NEAR(y[i], std::sin(x[i]), 2e-3);
    }
  }
}

TEST_F(PlotData, AGapStaysAGapAndHidesNoPeak) {
  const double nothing = std::nan("");
  Plot plot{.x_label = "t", .y_label = "y"};
  plot.series.push_back({.name = "a", .points = {{0, 1}, {1, nothing}, {2, nothing}, {3, 2}}});
  plot.series.push_back({.name = "long"});
  for (int i = 0; i < 9'000; ++i) {
    plot.series[1].points.emplace_back(i, i % 3 == 0 ? nothing : i == 4'000 ? 9.0 : 1.0);
  }
  const auto data = data_of(plot);
  const auto y = data["series"][0]["y"]["d"];
  ASSERT_EQ(y.size(), 3U);
  EXPECT_TRUE(y[0].is_number() && y[1].is_null() && y[2].is_number());
  const auto x = values(data["series"][0]["x"]);
  ASSERT_EQ(x.size(), 3U);
  EXPECT_NEAR(x[1], 1, 1e-4);
  EXPECT_NEAR(x[2], 3, 1e-4);
  double most = 0;
  double sum = 0;
  for (const auto& d : data["series"][1]["y"]["d"]) {
    if (!d.is_null()) most = std::max(most, sum += d.get<double>());
  }
  EXPECT_NEAR(most * data["series"][1]["y"]["k"].get<double>(), 9.0, 1e-3);
}

TEST_F(PlotData, NoTextOfARunEndsTheElement) {
  Plot plot{.x_label = "</script><script>alert(1)</script>"};
  plot.marks.push_back({.x = 1, .text = "</script>"});
  const std::string block = plot_block(plot);
  EXPECT_EQ(block.find("</script>"), block.size() - 9);
  EXPECT_EQ(data_of(plot)["x_label"], plot.x_label);
}

TEST_F(PlotData, AReportWithPlotsHasTheScriptOnce) {
  Plot plot{.y_label = "y"};
  plot.series.push_back({.name = "a", .points = {{0, 1}, {1, 2}}});
  const std::string html = with_plot_script("<body>" + plot_block(plot) + "</body>");
  EXPECT_NE(html.find("<script>draw();</script>\n</body>"), std::string::npos) << html;
  EXPECT_EQ(with_plot_script("<body></body>"), "<body></body>") << "nothing to draw";
}

TEST_F(PlotData, EachPageOfHilsHasItsPlotsAsDrawingsAndForTheScript) {
  Document page{"sweep"};
  Plot plot{.y_label = "y"};
  plot.series.push_back({.name = "best", .points = {{1, 2}}, .dots = true});
  page.add(plot);
  const std::string html = write_html(page);
  EXPECT_NE(html.find("<figure><svg"), std::string::npos) << html;
  EXPECT_NE(html.find("<script type=\"application/json\" class=\"plot\">"), std::string::npos);
  EXPECT_NE(html.find("<script>draw();</script>\n</body>"), std::string::npos);
  EXPECT_EQ(data_of(plot)["series"][0]["dots"], true);
}

TEST_F(PlotData, MapsAndPagesThatWereNotBuiltLeaveTheDrawing) {
  EXPECT_EQ(plot_block({.equal_scales = true}), "");
  const cas::test::TemporaryFolder older;  // a page without this script
  older.write("index.html", "");
  ::setenv("CAS_WEB_PATH", older.path().c_str(), 1);
  EXPECT_EQ(plot_block({}), "");
}

}  // namespace
}  // namespace cas::hils
