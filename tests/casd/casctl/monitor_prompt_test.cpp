// SPDX-License-Identifier: BSD-3-Clause
#include "casd/casctl/monitor/prompt.hpp"

#include <gtest/gtest.h>

#include "casd/casctl/completion_words.hpp"

namespace cas::casctl {
namespace {

using nlohmann::json;

TEST(MonitorPrompt, TurnsALineIntoACall) {
  const auto takeoff = std::get<PromptCall>(parse_prompt("takeoff 3"));
  EXPECT_EQ(takeoff.method, "vehicle.takeoff");
  EXPECT_EQ(takeoff.params, (json{{"altitude_m", 3.0}}));
  EXPECT_EQ(std::get<PromptCall>(parse_prompt("goto 5 -2 -3")).params,
            (json{{"north_m", 5.0}, {"east_m", -2.0}, {"down_m", -3.0}}));
  EXPECT_EQ(std::get<PromptCall>(parse_prompt("setgain rollrate 0.1 0.2")).params,
            (json{{"loop", "rollrate"}, {"p", 0.1}, {"i", 0.2}}));
  const auto set = std::get<PromptCall>(parse_prompt("param set MC_ROLL_P 6.5"));
  EXPECT_EQ(set.method, "param.set");
  EXPECT_EQ(set.params, (json{{"name", "MC_ROLL_P"}, {"value", 6.5}}));
  EXPECT_EQ(std::get<PromptCall>(parse_prompt("message-interval 30 20")).params,
            (json{{"message", 30}, {"hz", 20.0}}));
  EXPECT_FALSE(std::get<PromptCall>(parse_prompt("log start")).of_vehicle);
}

TEST(MonitorPrompt, NeverOverrulesTheInterlock) {
  for (const char* line : {"arm", "disarm", "takeoff 3", "land", "mode HOLD"}) {
    EXPECT_FALSE(std::get<PromptCall>(parse_prompt(line)).params.contains("not_hil")) << line;
  }
  EXPECT_EQ(std::get<std::string>(parse_prompt("arm not_hil")), "usage: arm");
}

TEST(MonitorPrompt, SaysWhatIsWrongWithALine) {
  const auto fault = [](const char* line) { return std::get<std::string>(parse_prompt(line)); };
  EXPECT_EQ(fault("fly"), "there is no command 'fly'; ? lists them");
  EXPECT_EQ(fault("tekeoff 3"), "there is no command 'tekeoff'; did you mean 'takeoff'?");
  EXPECT_EQ(fault("takeoff"), "usage: takeoff ALT");
  EXPECT_EQ(fault("takeoff high"), "'high' is no number; usage: takeoff ALT");
  EXPECT_EQ(fault("land now"), "usage: land");
  EXPECT_EQ(fault("param"), "behind 'param' stands one of get, set");
}

TEST(MonitorPrompt, SaysWhatCameOfACall) {
  EXPECT_EQ(answer_text({.method = "vehicle.arm"}, {{"result", "ACCEPTED"}}), "ACCEPTED");
  EXPECT_EQ(answer_text({.method = "param.get"}, {{"name", "MC_ROLL_P"}, {"value", 6.5}}),
            "MC_ROLL_P = 6.5");
  EXPECT_EQ(answer_text({.method = "gain.set"}, {{"loop", "roll"}, {"p", 6.5}}), "roll: P 6.5");
  EXPECT_EQ(
      answer_text({.method = "gain.set"}, {{"loop", "roll"}, {"p", 6.5}, {"before", {{"p", 6.4}}}}),
      "roll: P 6.4 -> 6.5");
}

class Completing : public testing::Test {
 protected:
  Completing() {
    words_.by_verb = completion_words();
    words_.messages = {"ATTITUDE", "ATTITUDE_QUATERNION", "HEARTBEAT"};
  }
  std::string completed(const std::string& line) const { return complete(line, words_).line; }

  PromptWords words_;
};

TEST_F(Completing, FinishesVerbs) {
  EXPECT_EQ(completed("tak"), "takeoff ");
  EXPECT_EQ(completed("par"), "param ");
  EXPECT_EQ(completed("param s"), "param set ");
  EXPECT_EQ(completed("xyz"), "xyz");
  EXPECT_EQ(complete("l", words_).offers, (std::vector<std::string>{"land", "log"}));
  EXPECT_EQ(complete("takeoff ", words_).usage, "takeoff ALT");
}

TEST_F(Completing, KnowsTheWordsOfTheShellsCompletion) {
  EXPECT_EQ(completed("mode pos"), "mode POS");  // POSCTL, POSHOLD
  EXPECT_EQ(completed("mode posc"), "mode POSCTL ");
  EXPECT_EQ(completed("setgain rollr"), "setgain rollrate ");
  EXPECT_EQ(completed("message-interval att"), "message-interval ATTITUDE");
  EXPECT_EQ(completed("setgain rollrate 0.1"), "setgain rollrate 0.1");
}

TEST_F(Completing, AsksForTheVehiclesParametersOnce) {
  EXPECT_TRUE(complete("param get MC", words_).wants_parameters);
  words_.parameters = {"MC_ROLLRATE_P", "MC_ROLLRATE_I", "SYS_HITL"};
  EXPECT_FALSE(complete("param get MC", words_).wants_parameters);
  EXPECT_EQ(completed("param get mc"), "param get MC_ROLLRATE_");
}

}  // namespace
}  // namespace cas::casctl
