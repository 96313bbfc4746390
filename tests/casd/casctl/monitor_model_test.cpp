// SPDX-License-Identifier: BSD-3-Clause
#include "casd/casctl/monitor/monitor_model.hpp"

#include <gtest/gtest.h>

#include "casd/casctl/monitor/monitor_view.hpp"
#include "tests/casd/casctl/monitor_answers.hpp"

namespace cas::casctl {
namespace {

using nlohmann::json;

class MonitorModelTest : public testing::Test {
 protected:
  MonitorModelTest() {
    status_ = {{"version", "0.1.0"},
               {"uptime_s", 5.0},
               {"threads", "per_link"},
               {"links", json::array({link_answer("sim", 500, 400), link_answer("fcu", 400, 500)})},
               {"vehicles", json::array({vehicle_answer()})}};
    messages_ = json::array({message_answer("fcu", "rx", 30, "ATTITUDE", 50),
                             message_answer("fcu", "rx", 0, "HEARTBEAT", 1),
                             message_answer("sim", "rx", 107, "HIL_SENSOR", 500),
                             message_answer("fcu", "tx", 107, "HIL_SENSOR", 500)});
    look(1);
  }

  void look(double time_s) {
    now_s_ = time_s;
    model_.update(status_, messages_, time_s);
    if (!status_["vehicles"].empty()) {
      model_.update_vehicle(state_answer(), telemetry_answer(), time_s);
    }
  }
  Block lines() const { return render(model_.state(), 24, 80, now_s_); }
  bool shows(const std::string& text) const { return line_of(text) < lines().size(); }
  /// Where the first line with this text is.
  std::size_t line_of(const std::string& text) const {
    const Block screen = lines();
    for (std::size_t i = 0; i < screen.size(); ++i) {
      if (screen[i].text().find(text) != std::string::npos) return i;
    }
    return screen.size();
  }
  Style style_of(const std::string& text) const {
    return lines().at(line_of(text)).spans.front().style;
  }

  json status_;
  json messages_;
  double now_s_ = 0;
  MonitorModel model_;
};

TEST_F(MonitorModelTest, FormsRatesOfLinksFromTwoLooks) {
  status_["links"][0]["rx"]["packets"] = 1000;
  look(2);
  const std::string line = lines()[line_of("sim")].text();
  EXPECT_NE(line.find(" 500 "), std::string::npos) << line;
}

TEST_F(MonitorModelTest, MarksALinkThatIsDown) {
  EXPECT_EQ(style_of("sim"), Style::kGood);
  status_["links"][0] =
      link_answer("sim", 500, 400, "down", "cannot open /dev/ttyACM0: no such file or directory");
  look(2);
  EXPECT_EQ(style_of("down"), Style::kBad);
  EXPECT_TRUE(shows("no such file or directory"));
}

TEST_F(MonitorModelTest, FiltersByNameLinkAndDirection) {
  model_.set_filter("hil");
  EXPECT_FALSE(shows("ATTITUDE"));
  EXPECT_TRUE(shows("HIL_SENSOR"));
  model_.cycle_link();  // sim
  model_.cycle_direction();
  EXPECT_TRUE(shows("only link sim rx /hil"));
  EXPECT_EQ(visible_rows(model_.state()).size(), 1U);
  model_.set_filter("nothing");
  EXPECT_TRUE(shows("no message passes the filter"));
}

TEST_F(MonitorModelTest, SortsByRate) {
  const auto first = [this] { return visible_rows(model_.state()).front().key.name; };
  EXPECT_EQ(first(), "ATTITUDE");
  model_.cycle_sort();
  EXPECT_EQ(first(), "HIL_SENSOR");
}

TEST_F(MonitorModelTest, KeepsTheSelectionWhenRowsMove) {
  model_.move(1);
  EXPECT_EQ(style_of("HEARTBEAT"), Style::kSelected);
  messages_.insert(messages_.begin(), message_answer("fcu", "rx", 33, "AAA", 5));
  look(2);
  EXPECT_EQ(style_of("HEARTBEAT"), Style::kSelected);
}

TEST_F(MonitorModelTest, OpensAMessageToItsFieldsWithTheirCourse) {
  model_.toggle_open();
  ASSERT_TRUE(model_.state().open.has_value());
  EXPECT_EQ(model_.state().open->name, "ATTITUDE");
  EXPECT_TRUE(shows("it came last"));
  for (const double roll : {0.0, 0.5, 1.0}) model_.update_value(attitude_answer(roll), 1 + roll);
  EXPECT_TRUE(shows("▁▅█"));
  EXPECT_TRUE(shows("roll in rad"));  // the plot, of the first field that is no time
  EXPECT_TRUE(shows("-10 s"));
  EXPECT_TRUE(shows("0.5 0.25 0 1 and 4 more"));
  model_.use_unicode(false);
  EXPECT_TRUE(shows("_=#"));
  model_.move_field(1);
  EXPECT_TRUE(shows("pitch in rad"));
  model_.toggle_open();
  EXPECT_FALSE(model_.state().open.has_value());
}

TEST_F(MonitorModelTest, OpensNoMessageThatWasSent) {
  model_.move(3);
  model_.move(-1);
  model_.toggle_open();
  EXPECT_FALSE(model_.state().open.has_value());
  EXPECT_TRUE(shows("pick a line with direction rx"));
}

TEST_F(MonitorModelTest, ShowsAndSelectsGains) {
  model_.show(MonitorModel::Page::kGains);
  model_.update_gains(json::array({{{"loop", "rollrate"}, {"p", 0.15}, {"i", 0.2}, {"d", 0.003}},
                                   {{"loop", "roll"}, {"p", 6.5}}}),
                      std::nullopt, 1);
  model_.move(5);
  ASSERT_TRUE(model_.selected_gain().has_value());
  EXPECT_EQ(model_.selected_gain()->at("loop"), "roll");
  EXPECT_TRUE(shows("rollrate"));
  EXPECT_TRUE(shows("0.003"));
  model_.update_gains({}, "the vehicle does not answer", 2);
  EXPECT_TRUE(shows("the vehicle does not answer"));
}

TEST_F(MonitorModelTest, SaysAtOnceThatThereIsNoVehicle) {
  status_["vehicles"] = json::array();
  status_["links"][0]["state"] = "down";
  MonitorModel fresh;
  fresh.update(status_, messages_, 1);
  std::string text;
  for (const ScreenLine& line : render(fresh.state(), 24, 80, 1)) text += line.text() + "\n";
  EXPECT_NE(text.find("NO VEHICLE"), std::string::npos) << text;
  EXPECT_NE(text.find("links up: fcu; down: sim"), std::string::npos) << text;
  EXPECT_EQ(text.find("reading"), std::string::npos) << text;
}

TEST_F(MonitorModelTest, TakesAVehicleForLostAfterThreeSecondsOfSilence) {
  EXPECT_TRUE(shows("in_air  2.52 m"));
  EXPECT_TRUE(shows("roll 12.3"));
  status_["vehicles"][0] = vehicle_answer(3.2);
  look(2);
  EXPECT_TRUE(shows("vehicle 1  PX4  LOST since 3.2 s"));
  EXPECT_FALSE(shows("2.52"));
  EXPECT_FALSE(shows("roll 12.3"));
  EXPECT_TRUE(shows("Last heard: HIL ARMED HOLD in_air"));
}

// In lockstep casd's clock stops with the stream: a HEARTBEAT does not age.
TEST_F(MonitorModelTest, TakesAVehicleForLostWhoseTimeStandsStill) {
  look(3);
  EXPECT_TRUE(shows("in_air  2.52 m"));
  look(5);
  EXPECT_TRUE(shows("LOST since 4.0 s"));
  messages_[0]["count"] = 11;
  look(6);
  EXPECT_TRUE(shows("in_air  2.52 m"));
}

TEST_F(MonitorModelTest, ShowsNothingAsFreshWhileCasdIsSilent) {
  model_.set_casd_fault("no casd at 127.0.0.1:5790");
  now_s_ = 13;
  EXPECT_TRUE(shows("CASD DOES NOT ANSWER since 12 s"));
  EXPECT_TRUE(shows("no casd at 127.0.0.1:5790"));
  EXPECT_FALSE(shows("in_air"));
  EXPECT_FALSE(shows("500.0"));  // a rate
  EXPECT_EQ(style_of("sim"), Style::kDim);
  EXPECT_NE(lines()[line_of("sim")].text().find(" - "), std::string::npos);
}

TEST_F(MonitorModelTest, ReplacesValuesOfASilentTopic) {
  model_.update_vehicle(state_answer(), telemetry_answer(7.5), 1);
  EXPECT_FALSE(shows("roll 12.3"));
  EXPECT_TRUE(shows("attitude 7.5 s old"));
  model_.show(MonitorModel::Page::kVehicle);
  EXPECT_FALSE(shows("12.3"));
  EXPECT_FALSE(shows("47.39"));
  EXPECT_TRUE(shows("No horizon: attitude 7.5 s old"));
}

TEST_F(MonitorModelTest, DoesNotShowWhereTheVehicleWasLongAgo) {
  json state = state_answer();
  state["landed_age_s"] = 1.0;
  model_.update_vehicle(state, telemetry_answer(), 1);
  EXPECT_TRUE(shows("in_air"));
  state["landed_age_s"] = 12.0;
  model_.update_vehicle(state, telemetry_answer(), 1);
  EXPECT_FALSE(shows("in_air"));
  EXPECT_TRUE(shows("landed state 12 s old"));
}

TEST_F(MonitorModelTest, ShowsAttitudeAndPosition) {
  model_.show(MonitorModel::Page::kVehicle);
  for (const char* text : {"12.3 deg", "-4.5 deg", "1.25 m", "-3.50 m", "47.3977421 deg",
                           "heading 91 deg", "from above", "Failsafe activated"}) {
    EXPECT_TRUE(shows(text)) << text;
  }
}

TEST_F(MonitorModelTest, SaysOnceWhatTheVehicleSaidManyTimes) {
  json state = state_answer();
  const json first = state["statustexts"][0];
  state["statustexts"] = json::array({first, first, first});
  model_.update_vehicle(state, telemetry_answer(), 1);
  model_.show(MonitorModel::Page::kVehicle);
  std::string text;
  for (const ScreenLine& line : render(model_.state(), 60, 80, 1)) text += line.text();
  EXPECT_NE(text.find("Ready for takeoff! (3 times)"), std::string::npos) << text;
}

TEST_F(MonitorModelTest, HoldsMessagesStillWhilePausedAndNotTheVehicle) {
  model_.toggle_pause();
  messages_ = json::array({message_answer("fcu", "rx", 33, "AAA", 5)});
  status_["vehicles"][0] = vehicle_answer(5);
  look(3);
  EXPECT_TRUE(shows("PAUSED 2.0 s"));
  EXPECT_TRUE(shows("ATTITUDE"));
  EXPECT_FALSE(shows("AAA"));
  EXPECT_TRUE(shows("LOST since"));
}

TEST_F(MonitorModelTest, ShowsTheNextOfSeveralVehicles) {
  model_.cycle_vehicle();
  EXPECT_TRUE(shows("casd hears no other vehicle"));
  json second = vehicle_answer();
  second["system"] = 2;
  second["mode"] = "LAND";
  status_["vehicles"].push_back(second);
  look(2);
  EXPECT_TRUE(shows("and 1 more (v)"));
  model_.cycle_vehicle();
  EXPECT_EQ(model_.state().chosen_vehicle, 2);
  EXPECT_TRUE(shows("LAND"));
  EXPECT_FALSE(shows("2.52 m"));  // the other one's altitude
  model_.cycle_vehicle();
  EXPECT_EQ(model_.state().chosen_vehicle, 1);
}

}  // namespace
}  // namespace cas::casctl
