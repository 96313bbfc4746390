// SPDX-License-Identifier: BSD-3-Clause
#include "hils/measure/judgement.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <nlohmann/json.hpp>

#include "hils/programs/cpu_pressure.hpp"
#include "tests/hils/report/run_text.hpp"

namespace cas::hils {
namespace {

RateFigures complete(double hz, std::uint64_t n) {
  return {.nominal_hz = hz, .sent = n, .received = n, .received_hz = hz, .drained = true};
}

Measurement good() {
  Measurement figures;
  figures.scenario = "hover";
  figures.over_hold = true;
  figures.window = {10'000'000, 40'000'000};
  figures.rates = {complete(500, 15001), complete(5, 151), complete(400, 12001)};
  figures.pace = {.real_time_factor = 1.0, .worst_stall_ms = 2, .late_p99_ms = 0.5};
  figures.rms = RmsFigures{.x_m = 0.1, .y_m = 0.1, .z_m = 0.05, .yaw_rad = 0.01, .samples = 3000};
  figures.sensor_to_control = {.count = 12001, .p50 = 1500, .p99 = 2500, .max = 9000};
  figures.handover_p99_us = 300;
  figures.reading_spread_us = 100;
  return figures;
}

Limits hover_limits() {
  Limits limits;
  limits.lost = 0;
  limits.rate_error_pct = 0.5;
  limits.figures = {{"rms_x_m", 0.25}, {"rms_y_m", 0.25}, {"rms_z_m", 0.15}, {"rms_yaw_rad", 0.05}};
  return limits;
}

TEST(Judgement, PassesAGoodRun) {
  const Verdict verdict = judge(good(), hover_limits());
  EXPECT_TRUE(verdict.passed);
  EXPECT_EQ(verdict.exit_code(), kExitPassed);
  EXPECT_TRUE(verdict.failures.empty());
}

struct MissCase {
  const char* name;
  void (*spoil)(Measurement&);
  const char* sentence;
};

TEST(MissedLimit, IsOneSentenceAndExitCodeOne) {
  const MissCase rows[] = {
      {"Loss", [](Measurement& m) { m.rates.gps.lost = 2; },
       "2 of 151 HIL_GPS were lost; the limit is 0"},
      {"Rate",
       [](Measurement& m) {
         m.rates.controls.received_hz = 390;
         m.rates.controls.error_pct = 2.5;
       },
       "HIL_CONTROLS arrived at 390.00 Hz instead of 400 Hz; the limit is 0.5 %"},
      {"Height", [](Measurement& m) { m.rms->z_m = 0.2; },
       "RMS error of the true position, z_m: 0.2000 m; the limit is 0.15 m"},
      {"NotANumber", [](Measurement& m) { m.rms->x_m = std::numeric_limits<double>::quiet_NaN(); },
       "RMS error of the true position, x_m: not measured; the limit is 0.25 m"},
      {"Flight", [](Measurement& m) { m.flight_failure = "arm was not done within 10 s"; },
       "the flight was not completed: arm was not done within 10 s"}};
  for (const auto& row : rows) {
    SCOPED_TRACE(row.name);
    Measurement figures = good();
    row.spoil(figures);
    const Verdict verdict = judge(figures, hover_limits());
    EXPECT_TRUE(verdict.valid);
    EXPECT_EQ(verdict.exit_code(), kExitLimitsMissed);
    ASSERT_EQ(verdict.failures.size(), 1U);
    EXPECT_EQ(verdict.failures.front(), row.sentence);
  }
}

const LimitCheck* find(const Verdict& verdict, const std::string& what) {
  const auto found = std::ranges::find(verdict.checks, what, &LimitCheck::what);
  return found == verdict.checks.end() ? nullptr : &*found;
}

TEST(Judgement, ListsEachLimitWithItsMargin) {
  Limits limits = hover_limits();
  limits.delivered_pct = 99;
  limits.figures["sensor_to_control_p99_us"] = 3000;
  Measurement figures = good();
  figures.rates.gps.received_hz = 4.99;
  figures.rates.gps.error_pct = -0.2;
  const Verdict verdict = judge(figures, limits);
  EXPECT_TRUE(verdict.passed);
  struct Expected {
    const char* what;
    double value, bound, margin;
  };
  for (const auto& [what, value, bound, margin] :
       {Expected{"RMS error of the true position, z_m", 0.05, 0.15, 0.1},
        Expected{"rate of HIL_GPS, error either way", 0.2, 0.5, 0.3},
        Expected{"HIL_SENSOR delivered", 100, 99, 1}, Expected{"HIL_CONTROLS lost", 0, 0, 0},
        Expected{"delay of the loop, 99 %", 2500, 3000, 500},
        Expected{"real-time factor", 1, 0.99, 0.01},
        Expected{"longest stall of the simulation", 2, 50, 48}}) {
    const LimitCheck* check = find(verdict, what);
    ASSERT_NE(check, nullptr) << what;
    EXPECT_TRUE(check->kept) << what;
    EXPECT_TRUE(check->sentence.empty()) << what;
    EXPECT_DOUBLE_EQ(check->value.value(), value) << what;
    EXPECT_DOUBLE_EQ(check->bound.value(), bound) << what;
    EXPECT_NEAR(check->margin().value(), margin, 1e-12) << what;
  }
}

TEST(Judgement, ListsWhatWasMissedWithANegativeMarginAndItsSentence) {
  Measurement figures = good();
  figures.rms->z_m = 0.2;
  figures.incidents = {{IncidentKind::kCrash, 23.4, "hit the ground at 9.5 m/s"}};
  const Verdict verdict = judge(figures, hover_limits());
  const LimitCheck* height = find(verdict, "RMS error of the true position, z_m");
  ASSERT_NE(height, nullptr);
  EXPECT_FALSE(height->kept);
  EXPECT_NEAR(height->margin().value(), -0.05, 1e-12);
  EXPECT_EQ(height->sentence, verdict.failures.back());
  const LimitCheck* crash = find(verdict, "incident: crash");
  ASSERT_NE(crash, nullptr);
  EXPECT_FALSE(crash->kept);
  EXPECT_EQ(crash->found, "at 23.40 s");
  const LimitCheck* flyaway = find(verdict, "incident: flyaway");
  ASSERT_NE(flyaway, nullptr);
  EXPECT_TRUE(flyaway->kept);
}

TEST(Judgement, JudgesNoLimitOfARunThatDoesNotCount) {
  Measurement figures = good();
  figures.pace.worst_stall_ms = 51;
  const Verdict verdict = judge(figures, hover_limits());
  for (const LimitCheck& check : verdict.checks) {
    EXPECT_EQ(check.judged, check.kind == LimitCheck::Kind::kValidity) << check.what;
  }
  EXPECT_NE(find(verdict, "RMS error of the true position, z_m"), nullptr);
}

TEST(Judgement, AFaultThatNeverBeganLeavesAGoodFlightWithoutAVerdict) {
  Measurement figures = good();
  figures.never_began = {{.name = "no GPS"}, {.name = "late", .by_time = true}};
  const Verdict verdict = judge(figures, hover_limits());
  EXPECT_EQ(verdict.exit_code(), kExitInvalid);
  EXPECT_EQ(verdict.failures, (std::vector<std::string>{
                                  "fault 'no GPS' never began: its condition never came true",
                                  "fault 'late' never began: the flight ended before its time"}));
  const auto json = test::vehicle_summary(figures, verdict);
  EXPECT_EQ(json.at("faults").at(0).at("name"), "no GPS");
  EXPECT_EQ(json.at("faults").at(0).at("began"), "never");
}

TEST(Judgement, AFaultThatNeverBeganIsARemarkOnAFlightThatFailed) {
  Measurement figures = good();
  figures.never_began = {{.name = "no GPS"}};
  figures.rms->z_m = 0.2;
  const Verdict verdict = judge(figures, hover_limits());
  EXPECT_EQ(verdict.exit_code(), kExitLimitsMissed);
  ASSERT_EQ(verdict.failures.size(), 2U);
  EXPECT_EQ(verdict.failures.back(), "fault 'no GPS' never began: its condition never came true");
  const LimitCheck* fault = find(verdict, "fault 'no GPS'");
  ASSERT_NE(fault, nullptr);
  EXPECT_FALSE(fault->judged);
}

TEST(Judgement, ACrashStandsBeforeTheStepThatWasNotDone) {
  Measurement figures = good();
  figures.flight_failure = "step 6, 'corner3' (goto), was not done within 1 s";
  figures.incidents = {{IncidentKind::kCrash, 23.4, "hit the ground at 9.5 m/s"}};
  const Verdict verdict = judge(figures, hover_limits());
  ASSERT_EQ(verdict.failures.size(), 2U);
  EXPECT_EQ(verdict.failures.front(), "the vehicle hit the ground at 9.5 m/s");
}

TEST(Judgement, NamesTheLimitsOfAMeasuredStepThatWasNotReached) {
  Limits limits = hover_limits();
  limits.responses["north"]["rise_s"] = 2;
  Measurement figures = good();
  figures.over_hold = false;
  figures.flight_failure = "step 3 (goto) was not done within 1 s";
  figures.rms.reset();
  const Verdict verdict = judge(figures, limits);
  for (const char* const what :
       {"RMS error of the true position, z_m", "rise time of step 'north'"}) {
    const LimitCheck* check = find(verdict, what);
    ASSERT_NE(check, nullptr) << what;
    EXPECT_FALSE(check->judged) << what;
    EXPECT_TRUE(check->bound) << what;
  }
}

TEST(Judgement, TheStepUnderWayAtTheEndIsAmongTheStages) {
  Measurement figures = good();
  figures.stages.emplace_back().step.name = "corner1";
  figures.under_way.emplace().step.name = "corner2";
  const auto stages = test::vehicle_summary(figures, judge(figures, {})).at("stages");
  ASSERT_EQ(stages.size(), 2U);
  EXPECT_FALSE(stages.at(0).contains("finished"));
  EXPECT_EQ(stages.at(1).at("name"), "corner2");
  EXPECT_EQ(stages.at(1).at("finished"), false);
}

TEST(Judgement, AnUnfinishedFlightFailsAtTheEndOfItsLastStep) {
  Measurement figures = good();
  figures.truth_samples = 1;
  figures.flight_failure = "the vehicle was disarmed during step 7 (goto)";
  figures.stages.emplace_back().end = base::SimTime(std::chrono::seconds(8));
  Stage& under_way = figures.under_way.emplace();
  under_way.begin = base::SimTime(std::chrono::seconds(8));
  under_way.end = base::SimTime(std::chrono::seconds(39));
  figures.incidents = {{IncidentKind::kCrash, 38.5, "hit 'silo'"}};
  const auto summary = test::vehicle_summary(figures, judge(figures, {}));
  ASSERT_EQ(summary.at("failures").size(), 2U);
  EXPECT_EQ(summary.at("failure_times_s"), nlohmann::json({38.5, 39.0}));
}

TEST(Judgement, RemarksWhichBoundsDoNotJudgeABoard) {
  Measurement figures = good();
  figures.handover_p99_us.reset();
  EXPECT_TRUE(judge(figures, hover_limits()).remarks.empty());
  figures.from_device = true;
  figures.reading_spread_us.reset();
  figures.age_by_arrival = {};
  EXPECT_EQ(judge(figures, hover_limits()).remarks,
            std::vector<std::string>{
                "not judged with a board: handover between simulator and casd, 99 % (not "
                "measured); HIL_SENSOR read by the controller, 99 % less the median (not "
                "measured); age of the sample at use (arrived), 99 % (not measured)"});
  figures.handover_p99_us = 100;
  figures.age_by_arrival = {.count = 3};
  EXPECT_EQ(judge(figures, hover_limits()).remarks,
            std::vector<std::string>{
                "not judged with a board: HIL_SENSOR read by the controller, 99 % less the median "
                "(not measured); age of the sample at use (arrived), 99 % (measured)"});
}

TEST(Judgement, AnUnmeasuredDelayMeetsNoLimit) {
  Limits limits = hover_limits();
  limits.figures["sensor_to_control_p99_us"] = 5000;
  Measurement figures = good();
  EXPECT_EQ(judge(figures, limits).exit_code(), kExitPassed);
  figures.sensor_to_control = {};
  const Verdict verdict = judge(figures, limits);
  EXPECT_EQ(verdict.exit_code(), kExitLimitsMissed);
  ASSERT_EQ(verdict.failures.size(), 1U);
  EXPECT_EQ(verdict.failures.front(),
            "delay of the loop, 99 %: not measured; the limit is 5000 us");
}

TEST(Judgement, HoldsAnyFigureToItsLimitOnTheSideThatIsWorse) {
  Limits limits = hover_limits();
  limits.figures["real_time_factor"] = 0.5;
  limits.figures["gps_lost"] = 2;
  limits.figures["rotor_activity_rad_s2"] = 90;
  limits.responses["north"]["integrated_error_m_s"] = 1;
  Measurement figures = good();
  figures.virtual_clock = true;
  figures.rotor_activity_rad_s2 = 90;
  figures.responses = {{.name = "north", .integrated_error = 1}};
  EXPECT_EQ(judge(figures, limits).exit_code(), kExitPassed);
  figures.pace.real_time_factor = 0.4;
  figures.rotor_activity_rad_s2 = 91;
  figures.responses.front().integrated_error = 1.25;
  EXPECT_EQ(
      judge(figures, limits).failures,
      (std::vector<std::string>{"integrated error of step 'north': 1.250 m s; the limit is 1 m s",
                                "real-time factor: 0.4000; the limit is 0.5",
                                "activity of the rotors: 91.0 rad/s^2; the limit is 90 rad/s^2"}));
}

TEST(Judgement, HoldsTheLargestErrorToItsLimit) {
  Limits limits = hover_limits();
  limits.figures["peak_error_m"] = 0.5;
  Measurement figures = good();
  figures.peak_error_m = 0.5;
  EXPECT_EQ(judge(figures, limits).exit_code(), kExitPassed);
  figures.peak_error_m = 1.8;
  EXPECT_EQ(
      judge(figures, limits).failures,
      std::vector<std::string>{"largest error of the true position: 1.800 m; the limit is 0.5 m"});
  figures.peak_error_m.reset();
  EXPECT_EQ(judge(figures, limits).exit_code(), kExitLimitsMissed) << "nothing was measured";
  figures.over_hold = false;
  figures.flight_failure = "arm: refused";
  EXPECT_EQ(judge(figures, limits).failures.size(), 1U) << "the step was not reached";
}

TEST(Judgement, RemarksOnAMeasuredStepWithoutLimits) {
  Verdict verdict = judge(good(), Limits{});
  EXPECT_TRUE(verdict.passed);
  ASSERT_EQ(verdict.remarks.size(), 1U);
  EXPECT_NE(test::run_text(good(), verdict).find("note: the scenario limits neither rms nor "),
            std::string::npos);
  EXPECT_NE(test::run_summary(good(), verdict).dump().find("the scenario limits neither rms nor "),
            std::string::npos);
  EXPECT_TRUE(judge(good(), hover_limits()).remarks.empty());
}

TEST(Judgement, ShowsNoFigureOfTheMachineThatWasNotMeasured) {
  Measurement nothing = good();
  nothing.handover_p99_us.reset();
  nothing.sensor_to_control = {};
  const Verdict verdict = judge(nothing, hover_limits());
  const auto check = std::ranges::find_if(verdict.checks, [](const LimitCheck& each) {
    return each.what == "handover between simulator and casd, 99 %";
  });
  ASSERT_NE(check, verdict.checks.end());
  EXPECT_FALSE(check->value);
  EXPECT_FALSE(check->judged);
  EXPECT_EQ(check->found, "not measured");
  const std::string text = test::run_text(nothing, verdict);
  EXPECT_NE(text.find("delay of the loop" + std::string(25, ' ') + "-"), std::string::npos) << text;
}

/// Ways in which the machine did not keep up, each just beyond its bound. Every limit is kept.
const MissCase kStarved[] = {
    {"Slow", [](Measurement& m) { m.pace.real_time_factor = 0.98; },
     "the simulation ran at 0.980 of real time, and 0.99 is needed"},
    {"NeverMeasured",
     [](Measurement& m) { m.pace.real_time_factor = std::numeric_limits<double>::quiet_NaN(); },
     "the simulation ran at nan of real time"},
    {"Stall", [](Measurement& m) { m.pace.worst_stall_ms = 51; },
     "the simulation fell behind by 51 ms within a second, and 50 ms is the most"},
    {"LateSteps", [](Measurement& m) { m.pace.late_p99_ms = 2.2; },
     "1 % of HIL_SENSOR left 2.2 ms late or later, and 2 ms is the most"},
    {"SlowController",
     [](Measurement& m) {
       m.age_by_arrival = {.count = 12001, .p50 = 100, .p99 = 4600, .max = 9000};
     },
     "the controller took 4.6 ms from a sample to its answer in 1 % of the cases, and 4.5 ms"},
    {"ControllerWithoutAProcessor", [](Measurement& m) { m.reading_spread_us = 10'000; },
     "1 % of HIL_SENSOR was read 10.0 ms later than the median one, and 2 ms is the most"},
    {"SlowPrograms", [](Measurement& m) { m.handover_p99_us = 113'000; },
     "simulator and casd took 113.0 ms to hand a packet over in 1 % of the cases"},
    {"PortOfFirmwareOnThisMachine", [](Measurement& m) { m.port_gap_ms = 51; },
     "no HIL_SENSOR came to the controller's port for 51 ms, and 50 ms is the most"}};

class StarvedMachine : public testing::TestWithParam<MissCase> {};

TEST_P(StarvedMachine, GivesNoVerdictWhetherLimitsAreKeptOrNot) {
  Measurement figures = good();
  GetParam().spoil(figures);
  for (const double z_m : {0.05, 9.7}) {
    figures.rms->z_m = z_m;
    const Verdict verdict = judge(figures, hover_limits());
    EXPECT_FALSE(verdict.valid);
    EXPECT_FALSE(verdict.passed);
    EXPECT_EQ(verdict.exit_code(), kExitInvalid);
    ASSERT_EQ(verdict.failures.size(), 1U);
    EXPECT_NE(verdict.failures.front().find(GetParam().sentence), std::string::npos)
        << verdict.failures.front();
    EXPECT_NE(verdict.failures.front().find("end other programs"), std::string::npos);
  }
}

TEST_P(StarvedMachine, IsNoMatterOfAVirtualClock) {
  Measurement figures = good();
  figures.virtual_clock = true;
  GetParam().spoil(figures);
  EXPECT_EQ(judge(figures, hover_limits()).exit_code(), kExitPassed);
}

INSTANTIATE_TEST_SUITE_P(All, StarvedMachine, testing::ValuesIn(kStarved),
                         [](const auto& test) { return test.param.name; });

TEST(Judgement, SaysOnceWhatHelpsABusyMachine) {
  Measurement figures = good();
  figures.pace = {.real_time_factor = 0.9, .worst_stall_ms = 100, .late_p99_ms = 20};
  figures.rates.sensor.received -= 1;  // an unaccounted packet
  const Verdict verdict = judge(figures, hover_limits());
  ASSERT_GE(verdict.failures.size(), 3U);
  const auto helps = [](const std::string& sentence) {
    return sentence.find("end other programs") != std::string::npos;
  };
  EXPECT_EQ(std::ranges::count_if(verdict.failures, helps), 1);
  EXPECT_TRUE(helps(verdict.failures[2])) << "behind the last of them";
}

TEST(Judgement, GivesNoVerdictOnLossesThatAPauseOfTheMachineExplains) {
  Measurement figures = good();
  figures.rates.sensor.lost = 10;
  figures.rates.sensor.received -= 10;
  EXPECT_EQ(judge(figures, hover_limits()).exit_code(), kExitLimitsMissed);
  figures.paused_ms = 19;  // in which 9.5 were due
  const Verdict verdict = judge(figures, hover_limits());
  EXPECT_EQ(verdict.exit_code(), kExitInvalid);
  ASSERT_EQ(verdict.failures.size(), 1U);
  EXPECT_NE(verdict.failures.front().find("10 of 15001 HIL_SENSOR were lost, and as many were due "
                                          "while packets stood still for 19 ms"),
            std::string::npos)
      << verdict.failures.front();

  Limits lenient = hover_limits();
  lenient.lost = 10;
  EXPECT_EQ(judge(figures, lenient).exit_code(), kExitPassed) << "a pause alone is no matter";
  figures.rates.sensor.lost = 11;
  EXPECT_EQ(judge(figures, hover_limits()).exit_code(), kExitLimitsMissed) << "more than were due";
  figures.rates.sensor.lost = 10;
  figures.faults.resize(1);
  EXPECT_EQ(judge(figures, hover_limits()).exit_code(), kExitLimitsMissed)
      << "a fault may hold packets up";
}

TEST(Judgement, HoldsAMachineThatJustKeepsUpForGood) {
  Measurement figures = good();
  figures.pace = {.real_time_factor = 0.99, .worst_stall_ms = 50, .late_p99_ms = 2};
  figures.handover_p99_us = 2000;
  figures.reading_spread_us = 2000;
  EXPECT_EQ(judge(figures, hover_limits()).exit_code(), kExitPassed);
}

TEST(Judgement, AFlightThatNobodyRecordedHasNoVerdict) {
  Measurement figures = good();
  figures.stages.resize(1);
  EXPECT_EQ(judge(figures, Limits{}).exit_code(), kExitInvalid);
  figures.truth_samples = 1;
  EXPECT_EQ(judge(figures, Limits{}).exit_code(), kExitPassed);
}

TEST(Judgement, AFlightWhoseRecordHasAHoleHasNoVerdict) {
  Measurement figures = good();
  figures.stages.resize(1);
  figures.truth_samples = 1;
  figures.record_hole = "it ends at 7.00 s, and the flight at 10.00 s";
  const Verdict verdict = judge(figures, Limits{});
  EXPECT_EQ(verdict.exit_code(), kExitInvalid);
  EXPECT_EQ(verdict.failures.front(),
            "the record of the true flight is not whole: " + *figures.record_hole);
}

TEST(Judgement, CpuPressureAloneDecidesNothing) {
  Measurement figures = good();
  figures.cpu_pressure = 0.995;
  EXPECT_EQ(judge(figures, hover_limits()).exit_code(), kExitPassed);
  figures.rates.sensor.lost = 3;
  EXPECT_EQ(judge(figures, hover_limits()).exit_code(), kExitLimitsMissed);
}

TEST(Judgement, FailsACrashWithoutAnyLimitUnlessItIsAllowed) {
  Measurement figures = good();
  figures.incidents = {{IncidentKind::kCrash, 23.4, "hit the ground at 9.5 m/s"}};
  Verdict verdict = judge(figures, Limits{});
  EXPECT_EQ(verdict.exit_code(), kExitLimitsMissed);
  ASSERT_EQ(verdict.failures.size(), 1U);
  EXPECT_EQ(verdict.failures.front(), "the vehicle hit the ground at 9.5 m/s");
  Limits allowing;
  allowing.allow = {IncidentKind::kAttitude};
  EXPECT_EQ(judge(figures, allowing).exit_code(), kExitLimitsMissed);
  allowing.allow = {IncidentKind::kCrash};
  EXPECT_EQ(judge(figures, allowing).exit_code(), kExitPassed);
}

TEST(CpuPressure, ReadsTheKernelsTotal) {
  EXPECT_EQ(parse_cpu_pressure("some avg10=87.49 avg60=89.17 avg300=88.17 total=5929389308"),
            std::chrono::microseconds(5'929'389'308));
  EXPECT_FALSE(parse_cpu_pressure("full avg10=0.00 total=0"));
  EXPECT_FALSE(parse_cpu_pressure("some avg10=0.00"));
}

TEST(Judgement, GivesNoVerdictWhenTheAccountDoesNotClose) {
  Measurement figures = good();
  figures.rates.sensor.unexplained = 1;
  EXPECT_EQ(judge(figures, hover_limits()).exit_code(), kExitInvalid);
}

TEST(TextReport, SaysWhyAFlightWithoutAVerdictEnded) {
  Measurement figures = good();
  figures.flight_failure = "the vehicle disarmed";
  const auto text = [&] { return test::run_text(figures, judge(figures, hover_limits())); };
  const std::string unjudged = "Not judged: the flight was not completed: the vehicle disarmed\n";
  EXPECT_EQ(text().find(unjudged), std::string::npos) << "the verdict says so:\n" << text();
  figures.rates.sensor.unexplained = 1;
  EXPECT_NE(text().find(unjudged), std::string::npos) << text();
}

TEST(TextReport, NamesTheClockAndMeasuresNoDelayInLockstep) {
  Measurement figures = good();
  const auto text = [&] { return test::run_text(figures, judge(figures, hover_limits())); };
  EXPECT_EQ(text().find("lockstep"), std::string::npos) << text();
  EXPECT_NE(text().find("Delay, us"), std::string::npos) << text();
  figures.virtual_clock = true;
  EXPECT_NE(text().find("TCAS on the virtual clock, seed"), std::string::npos) << text();
  figures.lockstep = true;
  EXPECT_NE(text().find("TCAS in lockstep, seed"), std::string::npos) << text();
  EXPECT_EQ(text().find("Delay, us"), std::string::npos) << text();
}

TEST(Summary, HasTheFieldsThatProgramsReadOff) {
  const Measurement figures = good();
  const auto run = test::run_summary(figures, judge(figures, hover_limits()));
  EXPECT_EQ(run.at("schema"), 2);
  for (const char* key : {"scenario", "architecture", "valid", "passed", "failures"}) {
    EXPECT_TRUE(run.contains(key)) << key;
  }
  ASSERT_EQ(run.at("vehicles").size(), 1U);
  nlohmann::json summary = run.at("vehicles").at(0);
  for (const char* message : {"HIL_SENSOR", "HIL_GPS", "HIL_CONTROLS"}) {
    for (const char* key : {"nominal_hz", "sent", "received", "lost", "received_hz", "error_pct"}) {
      EXPECT_TRUE(summary["rates"][message].contains(key)) << message << " " << key;
    }
  }
  EXPECT_EQ(summary["latency_us"]["sensor_to_control"]["p99"], 2500);
  EXPECT_EQ(summary["rms"]["x_m"], 0.1);
  EXPECT_TRUE(summary["rms_estimate"].is_null());
}

TEST(TextReport, ShowsThePapersRowsBelowOurs) {
  const Measurement figures = good();
  const std::string text = test::run_text(figures, judge(figures, hover_limits()), true);
  EXPECT_NE(text.find("431.8999"), std::string::npos) << text;
  EXPECT_NE(text.find("0.0996"), std::string::npos) << text;
}

}  // namespace
}  // namespace cas::hils
