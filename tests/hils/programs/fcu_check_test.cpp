// SPDX-License-Identifier: BSD-3-Clause
#include "hils/programs/fcu_check.hpp"
#include "tests/support/paths.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>

namespace cas::hils {
namespace {

FcuFacts ready() {
  return {.device = "/dev/ttyACM0",
          .link_up = true,
          .link_words = "/dev/ttyACM0 921600",
          .heard = true,
          .hil = true,
          .armed = false,
          .autopilot = "px4",
          .sys_hitl = 1,
          .sensor_hz = 500,
          .controls_hz = 400,
          .crc_errors = 0,
          .by_rotor = true};
}

base::Vehicle vehicle(const std::string& name) {
  return base::Vehicle::load(cas::test::source_dir() + "/config/vehicles/" + name + ".yaml");
}

TEST(FcuCheck, LetsAReadyControllerFly) {
  const auto findings = check_fcu(ready(), {}, vehicle("iris_px4"));
  EXPECT_TRUE(may_fly(findings)) << findings_text(findings);
  for (const FcuFinding& finding : findings) EXPECT_TRUE(finding.good) << finding.what;
}

struct Fault {
  const char* name;
  void (*spoil)(FcuFacts&);
  bool fatal;
  const char* words;
};

class FcuCheckFault : public testing::TestWithParam<Fault> {};

TEST_P(FcuCheckFault, IsNamedWithARemedy) {
  FcuFacts facts = ready();
  GetParam().spoil(facts);
  const auto findings = check_fcu(facts, {}, vehicle("iris_px4"));
  EXPECT_EQ(may_fly(findings), !GetParam().fatal);
  const std::string text = findings_text(findings);
  EXPECT_NE(text.find(GetParam().words), std::string::npos) << text;
  for (const FcuFinding& finding : findings) EXPECT_EQ(finding.good, finding.remedy.empty());
}

INSTANTIATE_TEST_SUITE_P(
    All, FcuCheckFault,
    testing::Values(
        Fault{"NoDevice", [](FcuFacts& f) { f.link_up = false; }, true, "cannot be opened"},
        Fault{"Silent", [](FcuFacts& f) { f.heard = false; }, true, "no HEARTBEAT"},
        Fault{"OtherSystem",
              [](FcuFacts& f) {
                f.heard = false;
                f.system = 2;
              },
              true, "no HEARTBEAT of system 2 came"},
        Fault{"Exchanged",
              [](FcuFacts& f) {
                f.system = 2;
                f.elsewhere = "fcu_left";
              },
              true, "system 2 is heard on link fcu_left"},
        Fault{"NotInHil", [](FcuFacts& f) { f.hil = false; }, true, "propellers"},
        Fault{"HitlOff", [](FcuFacts& f) { f.sys_hitl = 0; }, true, "SYS_HITL is 0"},
        Fault{"Armed", [](FcuFacts& f) { f.armed = true; }, true, "armed already"},
        Fault{"NoControls", [](FcuFacts& f) { f.controls_hz = 0; }, true, "SYS_AUTOSTART"},
        Fault{"StockRate", [](FcuFacts& f) { f.controls_hz = 200; }, false, "200 for PX4"},
        Fault{"NarrowLine", [](FcuFacts& f) { f.sensor_hz = 310; }, false, "310 of 500"},
        Fault{"Damaged", [](FcuFacts& f) { f.crc_errors = 7; }, false, "7 packets came damaged"},
        Fault{"ArduPilot", [](FcuFacts& f) { f.autopilot = "ardupilot"; }, true, "ArduPilot"}),
    [](const auto& test) { return test.param.name; });

TEST(FcuCheckControlsRate, IsComparedWithTheScenarios) {
  struct RateCase {
    const char* name;
    double board_hz;
    double scenario_hz;
    const char* autopilot;
    const char* what;    ///< in the finding; empty: the rates agree
    const char* remedy;  ///< in the remedy
  };
  const RateCase rows[] = {
      {"Same", 200, 200, "px4", "", ""},
      {"NearlySame", 391, 400, "generic", "", ""},
      {"StockPx4InThePapersScenario", 200, 400, "px4",
       "200 controls a second; the scenario counts on 400: the report would call 200 a "
       "second missing",
       "200 for PX4 (step 5)"},
      {"OurControllerInPx4sScenario", 400, 200, "generic",
       "400 controls a second; the scenario counts on 200: the report would call 200 a "
       "second too many",
       "about 400"},
      {"AnyBoard", 250, 400, "generic", "150 a second missing", "about 250"}};
  for (const auto& row : rows) {
    SCOPED_TRACE(row.name);
    FcuFacts facts = ready();
    facts.autopilot = row.autopilot;
    facts.controls_hz = row.board_hz;
    Rates nominal;
    nominal.controls_hz = row.scenario_hz;
    const auto findings = check_fcu(facts, nominal, vehicle("iris_px4"));
    const std::string text = findings_text(findings);
    EXPECT_TRUE(may_fly(findings)) << text;
    const auto bad = std::ranges::count_if(findings, [](const auto& f) { return !f.good; });
    EXPECT_EQ(bad, *row.what == 0 ? 0 : 1) << text;
    EXPECT_NE(text.find(row.what), std::string::npos) << text;
    EXPECT_NE(text.find(row.remedy), std::string::npos) << text;
  }
}

TEST(FcuCheckRotors, AreThoseOfTheFirmware) {
  struct RotorCase {
    const char* name;
    const char* vehicle;
    const char* autopilot;
    bool by_rotor;
    bool may_fly;
  };
  const RotorCase rows[] = {{"Iris", "iris_px4", "px4", true, true},
                            {"X500", "x500", "px4", true, true},
                            {"QuadX", "quad_x", "px4", true, true},
                            {"HexaX", "hexa_x", "px4", true, true},
                            {"Y6", "y6", "px4", true, true},
                            {"ThePapersOrder", "iris_paper", "px4", true, false},
                            {"ThePapersOrderByAxes", "iris_paper", "px4", false, true},
                            {"ThePapersOrderElsewhere", "iris_paper", "generic", true, true}};
  for (const auto& row : rows) {
    SCOPED_TRACE(row.name);
    FcuFacts facts = ready();
    facts.autopilot = row.autopilot;
    facts.by_rotor = row.by_rotor;
    const auto findings = check_fcu(facts, {}, vehicle(row.vehicle));
    const std::string text = findings_text(findings);
    EXPECT_EQ(may_fly(findings), row.may_fly) << text;
    EXPECT_EQ(text.find("it would flip") == std::string::npos, row.may_fly) << text;
  }
}

}  // namespace
}  // namespace cas::hils
