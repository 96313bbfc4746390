// SPDX-License-Identifier: BSD-3-Clause
#include "casd/casctl/monitor/monitor_model.hpp"

#include <gtest/gtest.h>

#include "casd/casctl/monitor/monitor_screen.hpp"

namespace cas::casctl {
namespace {

using nlohmann::json;

json link(const std::string& name, int rx, int tx, const std::string& state = "up") {
  return {{"name", name},
          {"type", "udp"},
          {"state", state},
          {"endpoint", "127.0.0.1:1"},
          {"rx", {{"packets", rx}, {"lost", 0}, {"crc_errors", 0}}},
          {"tx",
           {{"packets", tx},
            {"dropped", {{"age", 0}}},
            {"queue_high_water", 1},
            {"forwarding_us", {{"p99", 60.0}}}}}};
}

json message(const std::string& on, const std::string& direction, int id, const std::string& name,
             double hz) {
  return {{"link", on},  {"direction", direction}, {"id", id},    {"name", name},
          {"system", 1}, {"component", 1},         {"count", 10}, {"hz", hz},
          {"age_s", 0.1}};
}

class MonitorModelTest : public testing::Test {
 protected:
  MonitorModelTest() {
    status_ = {{"version", "0.1.0"},
               {"uptime_s", 5.0},
               {"threads", "per_link"},
               {"links", json::array({link("sim", 500, 400), link("fcu", 400, 500)})},
               {"vehicles", json::array()}};
    messages_ = json::array({message("fcu", "rx", 30, "ATTITUDE", 50),
                             message("fcu", "rx", 0, "HEARTBEAT", 1),
                             message("sim", "rx", 107, "HIL_SENSOR", 500),
                             message("fcu", "tx", 107, "HIL_SENSOR", 500)});
    model_.update(status_, messages_, 1);
  }

  std::string screen(std::size_t rows = 24, std::size_t width = 80) const {
    std::string text;
    for (const ScreenLine& line : model_.render(rows, width)) text += line.text + "\n";
    return text;
  }
  bool shows(const std::string& text) const { return screen().find(text) != std::string::npos; }
  /// Where the first line with this text is.
  std::size_t line_of(const std::string& text) const {
    const auto lines = model_.render(24, 80);
    for (std::size_t i = 0; i < lines.size(); ++i) {
      if (lines[i].text.find(text) != std::string::npos) return i;
    }
    return lines.size();
  }

  json status_;
  json messages_;
  MonitorModel model_;
};

struct SizeCase {
  const char* name;
  std::size_t rows;
  std::size_t width;
};

class MonitorSizes : public MonitorModelTest, public testing::WithParamInterface<SizeCase> {};

TEST_P(MonitorSizes, FillsTheScreenExactly) {
  const auto& [name, rows, width] = GetParam();
  const auto lines = model_.render(rows, width);
  EXPECT_EQ(lines.size(), rows);
  for (const ScreenLine& line : lines) EXPECT_EQ(columns(line.text), width);
}

INSTANTIATE_TEST_SUITE_P(Screens, MonitorSizes,
                         testing::Values(SizeCase{"Small", 10, 40}, SizeCase{"Vt100", 24, 80},
                                         SizeCase{"Wide", 50, 160}),
                         [](const auto& test) { return test.param.name; });

TEST_F(MonitorModelTest, FormsRatesOfLinksFromTwoLooks) {
  status_["links"][0]["rx"]["packets"] = 1000;
  model_.update(status_, messages_, 2);
  EXPECT_TRUE(shows("sim       up          500"));
}

TEST_F(MonitorModelTest, MarksALinkThatIsDown) {
  status_["links"][0] = link("sim", 500, 400, "down");
  model_.update(status_, messages_, 2);
  EXPECT_EQ(model_.render(24, 80)[line_of("down")].style, Style::kBad);
}

TEST_F(MonitorModelTest, FiltersByNameLinkAndDirection) {
  model_.set_filter("hil");
  EXPECT_FALSE(shows("ATTITUDE"));
  EXPECT_TRUE(shows("HIL_SENSOR"));
  model_.cycle_link();  // sim
  model_.cycle_direction();
  EXPECT_TRUE(shows("sim       rx"));
  EXPECT_FALSE(shows("fcu       tx"));
  model_.set_filter("nothing");
  EXPECT_TRUE(shows("no message passes the filter"));
}

TEST_F(MonitorModelTest, SortsByRate) {
  EXPECT_LT(line_of("ATTITUDE"), line_of("HEARTBEAT"));
  EXPECT_LT(line_of("HEARTBEAT"), line_of("sim       rx"));
  model_.cycle_sort();
  EXPECT_LT(line_of("HIL_SENSOR"), line_of("ATTITUDE"));
}

TEST_F(MonitorModelTest, KeepsTheSelectionWhenRowsMove) {
  model_.move(1);
  EXPECT_EQ(model_.render(24, 80)[line_of("HEARTBEAT")].style, Style::kSelected);
  messages_.insert(messages_.begin(), message("fcu", "rx", 33, "AAA", 5));
  model_.update(status_, messages_, 2);
  EXPECT_EQ(model_.render(24, 80)[line_of("HEARTBEAT")].style, Style::kSelected);
}

TEST_F(MonitorModelTest, OpensAMessageToItsFieldsWithTheirCourse) {
  model_.toggle_open();
  ASSERT_TRUE(model_.open().has_value());
  EXPECT_EQ(model_.open()->name, "ATTITUDE");
  EXPECT_TRUE(shows("waiting for the next packet"));
  for (const double roll : {0.0, 0.5, 1.0}) {
    model_.update_value(
        {{"id", 30},
         {"fields", json::array({{{"name", "roll"}, {"value", roll}, {"units", "rad"}}})}});
  }
  EXPECT_TRUE(shows("roll"));
  EXPECT_TRUE(shows("▁▅█"));
  model_.use_unicode(false);
  EXPECT_TRUE(shows("_=#"));
  model_.toggle_open();
  EXPECT_FALSE(model_.open().has_value());
}

TEST_F(MonitorModelTest, ShowsAndSelectsGains) {
  model_.show(MonitorModel::Page::kGains);
  model_.update_gains(json::array({{{"loop", "rollrate"}, {"p", 0.15}, {"i", 0.2}, {"d", 0.003}},
                                   {{"loop", "roll"}, {"p", 6.5}}}));
  model_.move(5);
  ASSERT_TRUE(model_.selected_gain().has_value());
  EXPECT_EQ(model_.selected_gain()->at("loop"), "roll");
  EXPECT_TRUE(shows("rollrate              0.15"));
}

TEST(ScreenText, CountsColumnsNotBytes) {
  EXPECT_EQ(columns("▁▅█"), 3U);
  EXPECT_EQ(fit("▁▅█", 2), "▁▅");
  EXPECT_EQ(fit("ab", 4), "ab  ");
}

TEST(MonitorPrompt, TurnsALineIntoACall) {
  const auto takeoff = std::get<PromptCall>(parse_prompt("takeoff 3"));
  EXPECT_EQ(takeoff.method, "vehicle.takeoff");
  EXPECT_EQ(takeoff.params, (json{{"altitude_m", 3.0}}));
  EXPECT_EQ(std::get<PromptCall>(parse_prompt("goto 5 -2 -3")).params,
            (json{{"north_m", 5.0}, {"east_m", -2.0}, {"down_m", -3.0}}));
  EXPECT_EQ(std::get<PromptCall>(parse_prompt("setgain rollrate 0.1 0.2")).params,
            (json{{"loop", "rollrate"}, {"p", 0.1}, {"i", 0.2}}));
}

TEST(MonitorPrompt, SaysWhatIsWrongWithALine) {
  EXPECT_EQ(std::get<std::string>(parse_prompt("fly")), "there is no command 'fly'; ? lists them");
  EXPECT_EQ(std::get<std::string>(parse_prompt("takeoff")), "usage: takeoff altitude_m");
  EXPECT_EQ(std::get<std::string>(parse_prompt("takeoff high")),
            "'high' is no number; usage: takeoff altitude_m");
  EXPECT_EQ(std::get<std::string>(parse_prompt("land now")), "usage: land");
}

}  // namespace
}  // namespace cas::casctl
