// SPDX-License-Identifier: BSD-3-Clause
#include "hils/firmware/disarming.hpp"

#include <gtest/gtest.h>

namespace cas::hils {
namespace {

/// PX4's own disarming of a vehicle that does not take off.
Disarming auto_disarmed() {
  return {.autopilot = "PX4", .words = "Disarmed by auto preflight disarming", .armed_s = 10};
}

/// ArduCopter's, which gives no reason.
Disarming silent_arducopter(double armed_s) {
  return {.autopilot = "ArduPilot", .armed_s = armed_s, .delay_s = 10};
}

HeardAct act(const char* what, bool disarms) {
  return {.by = "255/190 on link gcs", .what = what, .disarms = disarms};
}

OutsideCall call(const char* method, const char* params = "{}") {
  OutsideCall made;
  made.params = params;
  made.client = "unix:uid 1000";
  made.method = method;
  return made;
}

TEST(Disarming, OfTheAutopilotItselfOnTheGroundIsUndone) {
  EXPECT_EQ(rearm_fault(auto_disarmed()), std::nullopt);
  EXPECT_EQ(rearm_fault(silent_arducopter(9)), std::nullopt);
  EXPECT_EQ(rearm_fault(silent_arducopter(12)), std::nullopt);
}

struct Case {
  const char* name;
  Disarming disarming;
  const char* sentence;  ///< part of it
};

Disarming with(Disarming all, void (*change)(Disarming&)) {
  change(all);
  return all;
}

class PerhapsByAPerson : public testing::TestWithParam<Case> {};

TEST_P(PerhapsByAPerson, IsNotUndone) {
  const std::string fault = rearm_fault(GetParam().disarming).value_or("");
  EXPECT_NE(fault.find(GetParam().sentence), std::string::npos) << fault;
  EXPECT_TRUE(fault.ends_with("; hils does not arm it again")) << fault;
}

INSTANTIATE_TEST_SUITE_P(
    Disarming, PerhapsByAPerson,
    testing::Values(
        Case{
            "StationThatDisarmed",
            with(auto_disarmed(),
                 [](Disarming& d) {
                   d.hands.acts = {act("MANUAL_CONTROL", false), act("command 400 (disarm)", true)};
                 }),
            "from outside (255/190 on link gcs: command 400 (disarm))"},
        Case{"StationThatOnlySteered",
             with(auto_disarmed(),
                  [](Disarming& d) { d.hands.acts = {act("MANUAL_CONTROL", false)}; }),
             "from outside (255/190 on link gcs: MANUAL_CONTROL)"},
        Case{"CallOfTheCommandPort",
             with(auto_disarmed(),
                  [](Disarming& d) {
                    d.hands.calls = {call("param.set"), call("vehicle.disarm")};
                  }),
             "from outside (unix:uid 1000 called vehicle.disarm)"},
        Case{"RawCommand",
             with(auto_disarmed(),
                  [](Disarming& d) {
                    d.hands.calls = {call("vehicle.command", R"({"command":400,"params":[0]})")};
                  }),
             R"((unix:uid 1000 called vehicle.command {"command":400,"params":[0]}))"},
        Case{"ItsOwnDelayWasChanged",
             with(auto_disarmed(),
                  [](Disarming& d) {
                    d.hands.calls = {call("param.set", R"({"name":"COM_DISARM_PRFLT","value":1})")};
                  }),
             R"(called param.set {"name":"COM_DISARM_PRFLT","value":1})"},
        Case{"ForgottenCalls",
             with(auto_disarmed(), [](Disarming& d) { d.hands.forgotten_calls = 3; }),
             "casd has forgotten 3 calls of its command port, so it is not known"},
        Case{"AboveTheGround", with(auto_disarmed(), [](Disarming& d) { d.highest_m = 0.5; }),
             "after it had been 0.5 m above the ground"},
        Case{"KillSwitch",
             with(auto_disarmed(), [](Disarming& d) { d.words = "Disarmed by kill-switch"; }),
             "perhaps by a person: it says \"Disarmed by kill-switch\""},
        Case{"NoWords", with(auto_disarmed(), [](Disarming& d) { d.words.clear(); }),
             "it does not say that it did so itself"},
        Case{"BeforeItsDelay", silent_arducopter(4),
             "its own DISARM_DELAY is 10 s, and it was armed for 4.0 s"},
        Case{"AfterItsDelay", silent_arducopter(15), "it was armed for 15.0 s"},
        Case{"DelaySwitchedOff", with(silent_arducopter(0.5), [](Disarming& d) { d.delay_s = 0; }),
             "DISARM_DELAY is 0"},
        Case{"DelayNotTold", with(silent_arducopter(10), [](Disarming& d) { d.delay_s.reset(); }),
             "it does not tell its DISARM_DELAY"},
        Case{"NeverSeenArmed", with(silent_arducopter(0), [](Disarming& d) { d.armed_s.reset(); }),
             "it was armed for 0.0 s"},
        Case{"ThirdTime",
             with(auto_disarmed(), [](Disarming& d) { d.armed_again = kMostRearmings; }),
             "disarmed itself 3 times before it took off"}),
    [](const auto& test) { return std::string(test.param.name); });

TEST(Disarming, BeforeTheFirstArmingKeepsTheVehicleDisarmed) {
  EXPECT_EQ(arm_fault({.calls = {call("param.set"), call("vehicle.arm")},
                       .acts = {act("another mode", false)}}),
            std::nullopt);
  EXPECT_EQ(
      arm_fault({.calls = {}, .acts = {act("command 400 (disarm)", true)}}),
      "somebody disarmed the vehicle, or may have, before hils armed it (255/190 on link gcs: "
      "command 400 (disarm)); hils does not arm it");
  for (const OutsideCall& disarm :
       {call("vehicle.disarm"), call("vehicle.command", R"({"command":400,"params":[0]})"),
        call("vehicle.command", R"({"command":400})"),
        call("vehicle.command", R"({"command":400,"params":[null]})"),
        call("vehicle.command", R"({"command":400,"params":[0.4]})"),
        call("vehicle.command", R"({"command":185,"params":[1]})"),
        call("vehicle.command", R"({"command":218,"params":[153,0]})"),
        call("vehicle.command", R"({"command":218,"params":[31,2]})"),
        call("vehicle.command", "null")}) {
    EXPECT_NE(arm_fault({.calls = {disarm}, .acts = {}}), std::nullopt)
        << disarm.method << disarm.params;
  }
  EXPECT_EQ(arm_fault({.calls = {call("vehicle.command", R"({"command":400,"params":[1]})"),
                                 call("vehicle.command", R"({"command":185})")},
                       .acts = {}}),
            std::nullopt);
  EXPECT_NE(arm_fault({.calls = {}, .acts = {}, .forgotten_calls = 1}), std::nullopt);
}

TEST(Disarming, AfterADisarmStepIsThatSteps) {
  EXPECT_TRUE(is_own_end(true, ""));
  EXPECT_TRUE(is_own_end(true, "Disarmed by external command"));
  EXPECT_TRUE(is_own_end(true, "DISARMED by Arm/Disarm component command"));
  EXPECT_TRUE(is_own_end(false, "Disarmed by landing"));
}

TEST(Disarming, AfterADisarmStepByATransmitterIsAPersons) {
  EXPECT_FALSE(is_own_end(true, "Disarmed by RC"));
  EXPECT_FALSE(is_own_end(true, "Disarmed by kill switch"));
  EXPECT_FALSE(is_own_end(false, "Disarmed by external command")) << "armed after hils's disarm";
  EXPECT_FALSE(is_own_end(false, ""));
}

TEST(Disarming, NamesWhoHadAHandInIt) {
  EXPECT_EQ(hands_words({}), "");
  EXPECT_EQ(hands_words({.calls = {}, .acts = {act("SET_MODE", false)}}),
            " (255/190 on link gcs: SET_MODE)");
}

}  // namespace
}  // namespace cas::hils
