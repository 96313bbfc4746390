// SPDX-License-Identifier: BSD-3-Clause
// The monitor's screen at every size: as wide as the terminal, and no word of it cut.
#include "casd/casctl/monitor/monitor_view.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <optional>
#include <set>
#include <sstream>

#include "casd/casctl/monitor/monitor_model.hpp"
#include "casd/casctl/session/text.hpp"
#include "tests/casd/casctl/monitor_answers.hpp"

namespace cas::casctl {
namespace {

using nlohmann::json;
using Page = MonitorState::Page;

constexpr double kNow_s = 20;

/// A bench as it is: long names, a link that is down, a vehicle that complains.
MonitorModel busy_bench() {
  MonitorModel model;
  json vehicle = vehicle_answer();
  vehicle["complaints"] =
      json::array({"the magnetometer is missing", "Preflight Fail: Compass sensors inconsistent"});
  const json status{
      {"version", "0.1.0"},
      {"uptime_s", 5.0},
      {"threads", "per_link"},
      {"links",
       json::array({link_answer("sim", 500, 400),
                    link_answer("fcu", 400, 500, "up", "/run/user/1000/cas/fcu0 921600"),
                    link_answer("gcs", 0, 0, "down", "cannot bind 0.0.0.0:14550: in use")})},
      {"vehicles", json::array({vehicle})}};
  json messages = json::array();
  int id = 1;
  for (const char* name :
       {"ATTITUDE", "GLOBAL_POSITION_INT", "OPEN_DRONE_ID_ARM_STATUS", "HEARTBEAT",
        "POSITION_TARGET_LOCAL_NED", "CAMERA_TRACKING_GEO_STATUS", "HIL_ACTUATOR_CONTROLS",
        "ESTIMATOR_STATUS", "AUTOPILOT_VERSION", "LOCAL_POSITION_NED", "EXTENDED_SYS_STATE"}) {
    messages.push_back(message_answer("fcu", "rx", id++, name, 123456.7));
    messages.push_back(message_answer("sim", "drop.bandwidth", id++, name, 0));
  }
  messages[0]["id"] = 30;
  model.update(status, messages, kNow_s - 1);
  model.update(status, messages, kNow_s);
  for (int i = 0; i < 10; ++i) {
    json telemetry = telemetry_answer();
    telemetry["position"]["north_m"] = 0.3 * i;
    model.update_vehicle(state_answer(), telemetry, kNow_s);
  }
  model.update_gains(json::array({{{"loop", "rollrate"}, {"p", 0.15}, {"i", 0.2}, {"d", 0.003}},
                                  {{"loop", "position"}, {"p", 6.5}}}),
                     std::nullopt, kNow_s);
  return model;
}

void open_attitude(MonitorModel& model) {
  model.toggle_open();
  for (const double roll : {-0.31, 0.0, 0.17}) {
    model.update_value(attitude_answer(roll), kNow_s - 1 + roll);
  }
}

/// A state of the monitor, by its change from the busy bench.
struct ViewCase {
  const char* name;
  std::function<void(MonitorModel&)> change;
};

std::vector<ViewCase> view_cases() {
  return {
      {"List", [](MonitorModel&) {}},
      {"OpenMessage", open_attitude},
      {"Gains", [](MonitorModel& model) { model.show(Page::kGains); }},
      {"Attitude", [](MonitorModel& model) { model.show(Page::kVehicle); }},
      {"Help", [](MonitorModel& model) { model.show(Page::kHelp); }},
      {"Ascii",
       [](MonitorModel& model) {
         open_attitude(model);
         model.use_unicode(false);
         model.toggle_pause();
       }},
      {"NoVehicle",
       [](MonitorModel& model) {
         json status = model.state().status;
         status["vehicles"] = json::array();
         model.update(status, json::array(), kNow_s);
       }},
      {"LostVehicle",
       [](MonitorModel& model) {
         json status = model.state().status;
         status["vehicles"][0]["heartbeat_age_s"] = 12.0;
         model.update(status, json::array(), kNow_s);
         model.set_answer("arm: the vehicle has not acknowledged after 5 tries; is its link up?",
                          true, kNow_s - 12);
       }},
      {"SilentCasd",
       [](MonitorModel& model) { model.set_casd_fault("127.0.0.1:5790 does not answer"); }},
      {"Prompt",
       [](MonitorModel& model) {
         model.set_prompt(": setgain rollrate 0.1", "setgain LOOP P [I] [D]; rollrate pitchrate");
       }},
  };
}

/// Words with a letter; those of drawings and numbers are none.
std::set<std::string> words_of(const Block& screen) {
  std::set<std::string> words;
  for (const ScreenLine& line : screen) {
    std::istringstream in(line.text());
    for (std::string word; in >> word;) {
      const bool has_letter =
          std::any_of(word.begin(), word.end(), [](unsigned char c) { return std::isalpha(c); });
      if (has_letter) words.insert(word);
    }
  }
  return words;
}

class MonitorView : public testing::TestWithParam<ViewCase> {
 protected:
  MonitorView() : model_(busy_bench()) { GetParam().change(model_); }
  Block screen(std::size_t rows, std::size_t width) const {
    return render(model_.state(), rows, width, kNow_s);
  }

  MonitorModel model_;
};

TEST_P(MonitorView, FillsEverySizeExactly) {
  for (std::size_t width = 60; width <= 300; ++width) {
    for (const std::size_t rows : {20U, 24U, 37U, 50U, 80U}) {
      const Block lines = screen(rows, width);
      ASSERT_EQ(lines.size(), rows) << width;
      for (const ScreenLine& line : lines) {
        ASSERT_EQ(columns(line), width) << rows << " rows: " << line.text();
      }
    }
  }
}

TEST_P(MonitorView, HasATitleBarAcrossTheWholeWidth) {
  for (std::size_t width = 60; width <= 300; ++width) {
    const ScreenLine title = screen(24, width).front();
    for (const Span& span : title.spans) {
      EXPECT_TRUE(span.style == Style::kTitle || span.style == Style::kAlarm) << title.text();
    }
  }
}

/// Words that appear only where something has no room.
const std::set<std::string> kOfLittleRoom{"complaint", "complaints", "more", "(key", "a)",
                                          "show",      "the",        "rest", "and",  "lines"};

/// Each text on a screen of any size is found, whole, on a screen that has room for all.
TEST_P(MonitorView, CutsNoWord) {
  std::set<std::string> whole;
  for (const auto& [rows, width] : {std::pair{200U, 159U}, {200U, 219U}, {200U, 600U}}) {
    whole.merge(words_of(screen(rows, width)));
  }
  for (std::size_t width = 60; width <= 300; ++width) {
    for (const std::size_t rows : {20U, 24U, 50U}) {
      for (const std::string& word : words_of(screen(rows, width))) {
        if (kOfLittleRoom.contains(word)) continue;
        ASSERT_TRUE(whole.contains(word)) << word << " at " << width << " x " << rows;
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Screens, MonitorView, testing::ValuesIn(view_cases()),
                         [](const auto& test) { return test.param.name; });

std::string text_of(const Block& screen) {
  std::string text;
  for (const ScreenLine& line : screen) text += line.text() + "\n";
  return text;
}

TEST(MonitorPanes, AreTwoFrom160ColumnsAndThreeFrom220) {
  MonitorModel model = busy_bench();
  open_attitude(model);
  for (const auto& [width, count] : {std::pair{159U, 1U}, {160U, 2U}, {219U, 2U}, {220U, 3U}}) {
    EXPECT_EQ(panes(width), count);
    const std::string line = render(model.state(), 50, width, kNow_s)[1].text();
    std::size_t edges = 0;
    for (std::size_t at = line.find(" │ "); at != std::string::npos;
         at = line.find(" │ ", at + 1)) {
      ++edges;
    }
    EXPECT_EQ(edges, count - 1) << line;
  }
}

TEST(MonitorPanes, ShowLinksMessagesValuesAttitudeAndGainsTogether) {
  MonitorModel model = busy_bench();
  open_attitude(model);
  for (const std::size_t width : {160U, 200U, 220U, 260U}) {
    const std::string text = text_of(render(model.state(), 60, width, kNow_s));
    for (const char* part : {"LINK", "MESSAGE", "roll in rad", "VEHICLE 1", "GAINS", "rollrate"}) {
      EXPECT_NE(text.find(part), std::string::npos) << part << " at " << width;
    }
  }
}

TEST(MonitorPanes, NeverCutTheNameOfAMessage) {
  const MonitorModel model = busy_bench();
  for (std::size_t width = 60; width <= 300; ++width) {
    const std::string text = text_of(render(model.state(), 80, width, kNow_s));
    for (const MessageRow& row : model.state().rows) {
      ASSERT_NE(text.find(row.key.name + " "), std::string::npos) << row.key.name << width;
    }
  }
}

TEST(MonitorHelp, FitsEightyByTwentyFour) {
  MonitorModel model = busy_bench();
  model.show(Page::kHelp);
  const std::string text = text_of(render(model.state(), 24, 80, kNow_s));
  EXPECT_EQ(text.find("show the rest"), std::string::npos) << text;
  for (const char* word : {"up, down", "takeoff ALT", "param set NAME VALUE", "log stop", "quit"}) {
    EXPECT_NE(text.find(word), std::string::npos) << word << "\n" << text;
  }
  model.move(50);
  const std::string small = text_of(render(model.state(), 16, 60, kNow_s));
  EXPECT_NE(small.find("show the rest"), std::string::npos);
  EXPECT_NE(small.find("quit"), std::string::npos) << small;
}

TEST(MonitorDrawing, PlotsBetweenRoundEndsOfBothAxes) {
  const std::deque<Sample> samples{{10, -0.31}, {12, 0.0}, {14, 0.17}};
  const std::string text = text_of(plot(samples, 15, 40, 8, true));
  for (const char* label : {"0.2", "-0.4", "-10 s", "now"}) {
    EXPECT_NE(text.find(label), std::string::npos) << label << "\n" << text;
  }
  EXPECT_EQ(columns(plot(samples, 15, 40, 8, false)[3]), 40U);
  const std::string huge =
      text_of(plot({{10, -1.7e308}, {12, 0.0}, {14, 1.7e308}}, 15, 40, 8, true));
  EXPECT_EQ(huge.find("nan"), std::string::npos) << huge;
  EXPECT_EQ(huge.find("inf"), std::string::npos) << huge;
  const Axis flat = round_axis(16.2, 16.2);
  EXPECT_LT(flat.low, 16.2);
  EXPECT_GT(flat.high, 16.2);
}

TEST(MonitorDrawing, LiftsTheGroundOnTheSideOfTheLowWing) {
  const auto ground_at = [](const Block& view, std::size_t row, bool at_the_right) {
    const std::string line = view[row].text();
    return (at_the_right ? line.back() : line.front()) == ':';
  };
  const Block right_down = horizon({.roll_deg = 30}, 40, 9, false);
  EXPECT_TRUE(ground_at(right_down, 4, true));
  EXPECT_FALSE(ground_at(right_down, 4, false));
  const Block nose_up = horizon({.pitch_deg = 15}, 40, 9, false);
  EXPECT_FALSE(ground_at(nose_up, 5, true));
  EXPECT_TRUE(ground_at(nose_up, 8, true));
}

TEST(MonitorDrawing, TurnsTheTapeWithTheHeading) {
  const Block east = heading_tape(90, 40, false);
  EXPECT_EQ(east[0].text().find('E'), 20U);
  EXPECT_EQ(east[1].text().find('^'), 20U);
  EXPECT_EQ(heading_tape(-90, 40, false)[0].text().find('W'), 20U);
}

TEST(MonitorDrawing, ShowsTheTrailWithItsScale) {
  const std::deque<Place> trail{{0, 0}, {0, 10}, {10, 10}};
  const std::string text = text_of(top_view(trail, 90.0, 50, 14, true));
  EXPECT_NE(text.find("→"), std::string::npos) << text;
  EXPECT_NE(text.find("+"), std::string::npos) << text;
  EXPECT_NE(text.find("N 10.6 m"), std::string::npos) << text;
}

TEST(ScreenText, LetsNoTextOfTheWireMoveTheCursor) {
  EXPECT_EQ(printable("a\x1b[2J\n\xc2\x9b"
                      "31m ▁"),
            "a?[2J??31m ▁");
  EXPECT_EQ(printable_lines("two\n\tlines\n"), "two\n?lines\n");
}

TEST(ScreenText, CountsColumnsNotBytes) {
  EXPECT_EQ(columns("▁▅█"), 3U);
  EXPECT_EQ(left("▁▅", 4), "▁▅  ");
  EXPECT_EQ(fit_words("one two three", 9), "one two");
  EXPECT_EQ(fit_words("one", 2), "");
  EXPECT_EQ(wrap("one two three", 8), (std::vector<std::string>{"one two", "three"}));
  EXPECT_EQ(wrap("abcdef", 4), (std::vector<std::string>{"abcd", "ef"}));
}

}  // namespace
}  // namespace cas::casctl
