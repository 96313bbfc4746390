// SPDX-License-Identifier: BSD-3-Clause
#include "hils/campaign/expectation.hpp"

#include <gtest/gtest.h>

#include <string>

#include "base/error.hpp"
#include "tests/support/refusal.hpp"

namespace cas::hils {
namespace {

std::vector<Expectation> expectations(const std::string& list) {
  return parse_expectations(
      base::ConfigNode::parse("expect: " + list, "campaign.yaml").at("expect"));
}
Expectation expectation(const std::string& one) { return expectations("[" + one + "]").at(0); }

/// Landed early, 4 m from where it was struck, after its position was lost.
StrikeResponse landed() {
  return {.strike_s = 20,
          .armed_before = true,
          .armed_after = true,
          .in_air = true,
          .detected_s = 1.5,
          .detected_by = "health: GPS",
          .reacted_s = 2.5,
          .reaction = "LAND",
          .completed = false,
          .incident = IncidentKind::kGround,
          .at_rest = true,
          .rest_m = 4,
          .farthest_m = 5,
          .peak_tilt_deg = 20};
}

TEST(OfALanding, IsKeptOrNot) {
  struct Case {
    const char* expectation;
    bool kept;
  };
  const Case rows[] = {{"stays_up", false},
                       {"no_crash", true},
                       {"crashes", false},
                       {"no_arming", false},
                       {"terminates", false},
                       {"detected", true},
                       {"detected_within_s: 1.5", true},
                       {"detected_within_s: 1.4", false},
                       {"lands", true},
                       {"lands_within_m: 4", true},
                       {"lands_within_m: 3.9", false},
                       {"failsafe: LAND", true},
                       {"{failsafe: RTL/LAND, within_s: 3}", true},
                       {"failsafe: RTL", false},
                       {"{failsafe: LAND, within_s: 2}", false},
                       {"no_farther_than_m: 5", true},
                       {"no_farther_than_m: 4.9", false},
                       {"tilts_less_than_deg: 20", true},
                       {"tilts_less_than_deg: 19", false}};
  for (const auto& row : rows) {
    SCOPED_TRACE(row.expectation);
    const auto miss = miss_of(expectation(row.expectation), landed());
    EXPECT_EQ(!miss, row.kept) << miss.value_or("kept");
  }
}

TEST(Expectation, OfWhatFellIsACrashAndNoLanding) {
  StrikeResponse fallen = landed();
  fallen.incident = IncidentKind::kCrash;
  fallen.crashed = true;
  fallen.detected_s.reset();
  fallen.reacted_s.reset();
  fallen.terminated = true;
  EXPECT_TRUE(miss_of(expectation("no_crash"), fallen));
  EXPECT_TRUE(miss_of(expectation("lands"), fallen));
  EXPECT_TRUE(miss_of(expectation("detected"), fallen));
  EXPECT_TRUE(miss_of(expectation("failsafe: LAND"), fallen)) << "none came";
  EXPECT_FALSE(miss_of(expectation("crashes"), fallen));
  EXPECT_FALSE(miss_of(expectation("terminates"), fallen));
}

TEST(Expectation, SaysThatACrashCameAfterATouchOfTheGround) {
  StrikeResponse fallen = landed();
  fallen.incident = IncidentKind::kGround;
  EXPECT_EQ(miss_of(expectation("stays_up"), fallen), "stays up: incident: ground");
  fallen.crashed = true;
  EXPECT_EQ(miss_of(expectation("no_crash"), fallen), "no crash: incident: ground, and a crash");
}

TEST(Expectation, OfWhatWasNotTriedIsMissed) {
  StrikeResponse stayed = landed();
  stayed.in_air = false;
  EXPECT_EQ(miss_of(expectation("lands"), stayed), "lands: it was not in the air");
  stayed.armed_after = false;
  EXPECT_EQ(miss_of(expectation("no_arming"), stayed),
            "no arming: the plan did not arm it after the strike");
  stayed.tried_to_arm = true;
  EXPECT_FALSE(miss_of(expectation("no_arming"), stayed));
}

TEST(Expectation, OfWhatLeftTheWorldIsMissed) {
  StrikeResponse gone = landed();
  gone.left_world = true;
  gone.crashed = true;
  for (const char* each : {"no_crash", "crashes", "detected", "lands", "no_farther_than_m: 9"}) {
    EXPECT_TRUE(miss_of(expectation(each), gone)) << each;
  }
}

TEST(Expectation, SaysWhatWasFound) {
  EXPECT_EQ(miss_of(expectation("lands_within_m: 3"), landed()),
            "lands within 3 m: it came to rest 4.0 m away");
  EXPECT_EQ(miss_of(expectation("{failsafe: RTL, within_s: 2}"), landed()),
            "failsafe RTL within 2 s: LAND after 2.50 s");
  EXPECT_EQ(miss_of(expectation("stays_up"), landed()), "stays up: incident: ground");
}

TEST(Expectation, RefusesWhatItDoesNotKnow) {
  for (const char* list :
       {"[]", "stays_up", "[stay_up]", "[{lands_within_m: -1}]", "[{lands_within: 10}]",
        "[{failsafe: ''}]", "[{failsafe: LAND/}]", "[{failsafe: land}]", "[{failsafe: RTL/LNAD}]",
        "[{no_farther_than_m: 1, tilts_less_than_deg: 2}]"}) {
    EXPECT_THROW(expectations(list), base::ConfigError) << list;
  }
  const std::string word = test::refusal([] { expectations("[stay_up]"); });
  EXPECT_NE(word.find("did you mean 'stays_up'"), std::string::npos) << word;
  const std::string mode = test::refusal([] { expectations("[{failsafe: LNAD}]"); });
  EXPECT_NE(mode.find("failsafe: there is no mode 'LNAD'; there are "), std::string::npos) << mode;
  EXPECT_NE(mode.find("did you mean 'LAND'"), std::string::npos) << mode;
}

TEST(Expectation, TakesTheModesOfBothAutopilots) {
  EXPECT_NO_THROW(expectations("[{failsafe: TERMINATION/HOLD/SMART_RTL/BRAKE}]"));
}

}  // namespace
}  // namespace cas::hils
