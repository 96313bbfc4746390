// SPDX-License-Identifier: BSD-3-Clause
// A flight of stock firmware, measured and judged.
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <functional>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "base/measure/ledger.hpp"
#include "casd/counters/link_ledger.hpp"
#include "hils/firmware/firmware_meeting.hpp"
#include "hils/firmware/firmware_pilot.hpp"
#include "hils/measure/hold_motion.hpp"
#include "hils/measure/judgement.hpp"
#include "hils/programs/fcu_device.hpp"
#include "mavlink/common/hil_sensor.hpp"
#include "tests/hils/report/run_text.hpp"
#include "tests/support/paths.hpp"
#include "tests/support/temporary_folder.hpp"

namespace cas::hils {
namespace {

const std::filesystem::path kScenarios = cas::test::source_dir() + "/config/scenarios";
constexpr const char* kHeader =
    "time_s,x_m,y_m,z_m,vx_m_s,vy_m_s,vz_m_s,roll_rad,pitch_rad,yaw_rad,p_rad_s,q_rad_s,r_rad_s,"
    "omega1_rad_s,omega2_rad_s,omega3_rad_s,omega4_rad_s\n";

base::SimTime at(double s) { return base::SimTime(base::from_seconds(s)); }

/// A flight of 10 s: armed, up to 10 m, held there, which is measured.
RunRecord flown() {
  RunRecord record;
  const auto add = [&](StepKind kind, double begin_s, double end_s, double height_m) {
    Stage stage{.step = {.kind = kind}, .begin = at(begin_s), .end = at(end_s), .accepted = {}};
    stage.step.measure = kind == StepKind::kHold;
    stage.reference_m = {0, 0, height_m};
    record.stages.push_back(stage);
  };
  add(StepKind::kArm, 0, 1, 0);
  add(StepKind::kTakeoff, 1, 5, 10);
  add(StepKind::kHold, 5, 10, 10);
  record.hold = record.stages.back();
  record.firmware.emplace();
  return record;
}

/// truth.csv of that flight. @param height  of the vehicle in the hold, by time
std::string truth(const std::function<double(double t)>& height) {
  std::string rows = kHeader;
  for (int i = 0; i <= 1000; ++i) {
    const double t = 0.01 * i;
    const auto z = [&height](double s) {
      return s < 1 ? 0 : s < 5 ? 2.5 * (s - 1) : std::max(0.0, height(s));
    };
    rows += std::to_string(t) + ",0,0," + std::to_string(z(t)) + ",0,0," +
            std::to_string((z(t) - z(t - 0.01)) / 0.01) + ",0,0,0,0,0,0,600,600,600,600\n";
  }
  return rows;
}

std::string steady_truth() {
  return truth([](double) { return 10; });
}

class FirmwareFlightFigures : public testing::Test {
 protected:
  /// Measures a record whose true flight is in a text.
  Measurement measured(RunRecord record, const std::string& text = steady_truth(),
                       const Scenario& scenario = {}) {
    record.truth_csv = folder_.write("truth.csv", text);
    record.flight_tlog = folder_.write("flight.tlog", "");
    return measure({.scenario = scenario}, record);
  }
  Verdict judged(RunRecord record, const Scenario& scenario = {}) {
    return judge(measured(std::move(record), steady_truth(), scenario), scenario.limits);
  }

  cas::test::TemporaryFolder folder_;
};

bool says(const Verdict& verdict, const std::string& words) {
  return std::ranges::any_of(verdict.failures, [&words](const std::string& sentence) {
    return sentence.find(words) != std::string::npos;
  });
}

TEST_F(FirmwareFlightFigures, OfACrashFailWithoutAnyLimit) {
  EXPECT_TRUE(judged(flown()).passed) << testing::PrintToString(judged(flown()).failures);
  const auto falling = [](double t) { return t < 7 ? 10 : 10 - 4.9 * (t - 7) * (t - 7); };
  const Verdict fallen = judge(measured(flown(), truth(falling)), {});
  EXPECT_TRUE(says(fallen, "hit the ground at ")) << testing::PrintToString(fallen.failures);
}

TEST_F(FirmwareFlightFigures, OfAHoldThatSwingsMissItsLimitsAlthoughTheMeanIsRight) {
  const auto swinging = [](double t) { return 10 + 1.8 * std::sin(2 * M_PI * (t - 5)); };
  const Measurement figures = measured(flown(), truth(swinging));
  EXPECT_NEAR(figures.height_error_m.value(), 0, 0.02);
  EXPECT_NEAR(figures.peak_error_m.value(), 1.8, 0.02);
  Limits limits = Scenario::load(kScenarios / "px4_sitl.yaml").limits;
  std::erase_if(limits.figures,
                [](const auto& limit) { return limit.first.starts_with("rms_estimate_"); });
  const Verdict verdict = judge(figures, limits);
  for (const char* missed : {"RMS error of the true position, z_m: 1.2728 m; the limit is 0.2 m",
                             "largest error of the true position: 1.800 m; the limit is 0.6 m"}) {
    EXPECT_TRUE(says(verdict, missed)) << testing::PrintToString(verdict.failures);
  }
}

TEST_F(FirmwareFlightFigures, CountTheHeadingFromTheMeanHeading) {
  std::string rows = kHeader;
  for (int i = 0; i < 1001; ++i) {  // to and fro about the angle where its numbers leap
    rows += std::to_string(0.01 * i) + ",0,0,10,0,0,0,0,0," + (i % 2 == 0 ? "3.0416" : "-3.0416") +
            ",0,0,0,0,0,0,0\n";
  }
  const Measurement figures = measured(flown(), rows);
  ASSERT_TRUE(figures.rms);
  EXPECT_NEAR(figures.rms->yaw_rad, 0.1, 1e-3);
}

TEST_F(FirmwareFlightFigures, OfAHoldThatWasNotFlownAreNone) {
  RunRecord record = flown();
  record.under_way = record.stages.back();
  record.stages.pop_back();
  record.hold.reset();
  record.flight_failure = "step 3 (hold) ended";
  const Measurement figures = measured(record);
  const auto summary = test::vehicle_summary(figures, judge(figures, {}));
  for (const char* key : {"height_error_m", "drift_m", "peak_error_m", "rms", "rms_estimate"}) {
    EXPECT_TRUE(summary.at(key).is_null()) << key;
  }
  EXPECT_EQ(summary.at("stages").back().at("finished"), false);
  EXPECT_FALSE(summary.contains("rates")) << "no HIL stream was measured";
}

TEST_F(FirmwareFlightFigures, OfRatesWaysAndDriftAreHeldToTheirLimits) {
  Scenario scenario;
  scenario.limits.rates_hz = {{"ATTITUDE", 20}};
  scenario.limits.figures = {{"hop_p99_us", 500}, {"drift_m", 1}, {"peak_error_m", 1}};
  EXPECT_EQ(judged(flown(), scenario).failures.size(), 2U) << "two were not measured";
  RunRecord record = flown();
  record.firmware->rates_hz = {{"ATTITUDE", 19}};
  record.firmware->hops = R"([{"link": "gcs", "routes": [{"from": "px4", "p99": 900.0}]}])";
  EXPECT_EQ(judged(record, scenario).failures,
            (std::vector<std::string>{"slowest way through casd, 99 %: 900 us; the limit is 500 us",
                                      "rate of ATTITUDE: 19.0 Hz; the limit is 20 Hz"}));
  record.firmware->rates_hz = {{"ATTITUDE", 21}};
  record.firmware->hops = R"([{"link": "gcs", "routes": [{"from": "px4", "p99": 400.0}]}])";
  EXPECT_TRUE(judged(record, scenario).passed);
}

TEST_F(FirmwareFlightFigures, OfAFlightThatBrokeOffAreNotJudged) {
  Scenario scenario;
  scenario.limits.figures = {{"rms_z_m", 0.1}, {"rms_estimate_z_m", 0.1}, {"drift_m", 1}};
  scenario.limits.rates_hz = {{"ATTITUDE", 20}};
  RunRecord record = flown();
  record.flight_failure = "step 2 (takeoff) was not done within 60 s";
  record.under_way = record.stages.back();
  record.stages.pop_back();
  record.hold.reset();
  const Verdict verdict = judged(record, scenario);
  EXPECT_EQ(verdict.failures,
            std::vector<std::string>{"the flight was not completed: " + *record.flight_failure});
  const auto not_reached = std::ranges::count(verdict.checks, "not reached", &LimitCheck::found);
  EXPECT_EQ(not_reached, 4);
}

TEST_F(FirmwareFlightFigures, OfASensorsLineThatStoodStillGiveNoVerdict) {
  const auto verdict_of = [this](const AhrsFigures& line) {
    RunRecord record = flown();
    record.firmware->ahrs = line;
    record.firmware->real_time_factor = 1;
    return judged(record);
  };
  const AhrsFigures good{.sent = 40'000, .dropped = 2, .late = 9, .longest_gap_ms = 12};
  EXPECT_NE(verdict_of(good).exit_code(), kExitInvalid);
  AhrsFigures still = good;
  still.longest_gap_ms = 55;
  EXPECT_EQ(verdict_of(still).exit_code(), kExitInvalid);
  AhrsFigures thin = good;
  thin.dropped = 500;
  EXPECT_EQ(verdict_of(thin).exit_code(), kExitInvalid);
  const Verdict silent = verdict_of(AhrsFigures{});
  EXPECT_EQ(silent.exit_code(), kExitInvalid);
  EXPECT_EQ(silent.failures.front(), "the sensors' line carried no packet") << "not: too busy";
}

TEST(AhrsFiguresTest, AreThoseOfTheVehiclesOwnPlugin) {
  const auto statistics = nlohmann::json::parse(
      R"({"plugins": {"external_ahrs@one": {"packets": 9, "dropped": 1, "reader_full": 2,
          "late": 3, "crc_errors": 4, "longest_gap_ms": 5.5}}})");
  const auto figures = ahrs_figures(statistics, "one");
  ASSERT_TRUE(figures);
  EXPECT_EQ(figures->sent, 9U);
  EXPECT_EQ(figures->dropped, 3U);
  EXPECT_EQ(figures->longest_gap_ms, 5.5);
  EXPECT_FALSE(ahrs_figures(statistics, "two"));
  EXPECT_FALSE(ahrs_figures({}, "one"));
}

/// The vehicle was disarmed before it took off.
RunRecord never_left_the_ground() {
  RunRecord record = flown();
  record.stages.resize(1);
  record.hold.reset();
  record.flight_failure = "the vehicle was disarmed before it took off, during step 2 (takeoff)";
  record.firmware->disarmed_on_ground = true;
  return record;
}

TEST_F(FirmwareFlightFigures, OfAVehicleThatStayedOnTheGroundUnhurtGiveNoVerdict) {
  const Verdict verdict = judged(never_left_the_ground());
  EXPECT_EQ(verdict.exit_code(), kExitInvalid);
  EXPECT_EQ(verdict.failures,
            (std::vector<std::string>{
                "the vehicle was disarmed before it took off, during step 2 (takeoff); it stands "
                "upright and unhurt, no fault has struck, and hils does not arm it again: the "
                "flight has no verdict"}));
}

TEST_F(FirmwareFlightFigures, OfAVehicleThatWasHarmedOnTheGroundFail) {
  const std::vector<std::function<void(Measurement&)>> harms{
      [](Measurement& f) { f.firmware->disarmed_on_ground = false; },
      [](Measurement& f) {
        f.incidents = {{IncidentKind::kStrike, 5, "hit something with rotor 1"}};
      },
      [](Measurement& f) { f.faults.emplace_back(); }};
  for (const auto& strike : harms) {
    Measurement figures = measured(never_left_the_ground());
    strike(figures);
    const Verdict verdict = judge(figures, {});
    EXPECT_EQ(verdict.exit_code(), kExitLimitsMissed);
    EXPECT_TRUE(says(verdict, *figures.flight_failure));
  }
}

TEST_F(FirmwareFlightFigures, MayTurnFarAheadOfAFenceOnlyWithAFirmwareThatLooksAhead) {
  Scenario scenario;
  scenario.fence = Geofence{.radius_m = 15, .margin_m = 5, .early_m = 10};
  RunRecord record = flown();
  record.stages.back().step.kind = StepKind::kBreach;
  record.firmware->fence.emplace().words = "Geofence";  // at 15 m; it turned 7.25 m from home
  const auto turned_early = [&](const char* version) {
    record.firmware->version = version;
    Measurement figures = measured(record, steady_truth(), scenario);
    figures.firmware->fence->farthest_m = 7.25;
    return judge(figures, {});
  };
  EXPECT_TRUE(turned_early("1.12.0").passed);
  EXPECT_EQ(turned_early("1.16.1").failures,
            std::vector<std::string>{
                "the vehicle did not come within 5.0 m of its fence: 7.25 m from home at most"});
}

TEST_F(FirmwareFlightFigures, WithoutTheFaultGiveNoVerdictWhereItWouldHavePassed) {
  Measurement figures = measured(flown());
  figures.never_began = {{.name = "squall"}};
  EXPECT_EQ(judge(figures, {}).exit_code(), kExitInvalid);
  figures.flight_failure = "arm: refused";
  EXPECT_EQ(judge(figures, {}).exit_code(), kExitLimitsMissed);
}

TEST(FirmwareFault, ThatCameAfterTheEndNeverBegan) {
  const auto faults = parse_scenario_faults(
      base::ConfigNode::parse("[{at_s: 11, drop: gps, for_s: 1, name: late}]", "test"),
      base::ConfigNode::empty());
  const auto never_with_begin = [&](double begin_s) {
    const BenchFaultScript::Span span{.name = "late", .begin = at(begin_s), .end = {}};
    return faults_that_never_began(faults, 0, {span}, flown().stages).size();
  };
  EXPECT_EQ(never_with_begin(9), 0U);
  EXPECT_EQ(never_with_begin(11), 1U) << "the programs ran on";
}

TEST_F(FirmwareFlightFigures, WithoutARecordGiveNoVerdict) {
  EXPECT_TRUE(says(judge(measured(flown(), kHeader), {}), "no record of the true flight"));
  RunRecord record = flown();
  record.truth_csv = folder_.path() / "none.csv";
  record.flight_tlog = folder_.write("flight.tlog", "");
  EXPECT_EQ(judge(measure({}, record), {}).exit_code(), kExitInvalid);
}

TEST_F(FirmwareFlightFigures, OfARecordWithAHoleGiveNoVerdict) {
  struct Case {
    const char* sentence;
    double from_s, to_s;  ///< rows that are missing
  };
  for (const auto& [sentence, from_s, to_s] :
       {Case{"it ends at 6.99 s, and the flight at 10.00 s", 7, 99},
        Case{"it has nothing between 5.99 s and 8.00 s", 6, 8},
        Case{"it begins at 2.00 s, and the flight at 0.00 s", -1, 2}}) {
    std::string rows;
    std::istringstream all(steady_truth());
    for (std::string line; std::getline(all, line);) {
      const double t = line.starts_with("t") ? -2 : std::stod(line);
      if (t < from_s || t >= to_s) rows += line + "\n";
    }
    const Verdict verdict = judge(measured(flown(), rows), {});
    EXPECT_EQ(verdict.exit_code(), kExitInvalid);
    EXPECT_TRUE(says(verdict, sentence)) << testing::PrintToString(verdict.failures);
  }
}

PoseSample sample(double time_s, Pose pose) {
  return {.time_us = static_cast<std::int64_t>(1e6 * time_s), .pose = pose};
}

TEST(FirmwareEstimate, IsComparedWithTheTruthByWhatTheyWereBeforeTakeoff) {
  RunRecord record = flown();  // takeoff from 1 s, hold from 5 to 10 s
  std::vector<PoseSample> truth;
  std::vector<PoseSample> estimate;
  for (int i = 0; i < 1000; ++i) {
    const double t = 0.01 * i;
    truth.push_back(sample(t, {.x_m = 1, .z_m = t < 1 ? 0.0 : 5.0, .yaw_rad = 0.5}));
    // Its origin is 3 m off; in the air it is 0.2 m too high and 0.1 rad off.
    estimate.push_back(
        sample(t, {.x_m = 4, .z_m = t < 1 ? 0.0 : 5.2, .yaw_rad = t < 1 ? 0.5 : 0.6}));
  }
  const auto error = estimate_error(record.stages, truth, estimate);
  ASSERT_TRUE(error);
  EXPECT_NEAR(error->x_m, 0, 1e-9);
  EXPECT_NEAR(error->z_m, 0.2, 1e-9);
  EXPECT_NEAR(error->yaw_rad, 0.1, 1e-9);
  EXPECT_FALSE(estimate_error(record.stages, truth, {}));
  FlightStep& takeoff = record.stages[1].step;
  takeoff.kind = StepKind::kMission;
  takeoff.mission.items = {{.command = mavlink::common::MavCmd::kNavTakeoff}};
  EXPECT_TRUE(estimate_error(record.stages, truth, estimate)) << "a mission that takes off";
}

// The stream in HITL

constexpr std::uint32_t kSensor = mavlink::common::HilSensor::kId;
constexpr std::uint64_t kPeriod_us = 4000;

/// Ledgers of 11 s of HIL_SENSOR at 250 Hz, of which casd's port gets those that `passes` lets.
RunRecord streamed(RunRecord record, const std::function<bool(std::uint64_t time_us)>& passes) {
  record.relay.emplace();
  for (std::uint64_t t = kPeriod_us; t < 11'000'000; t += kPeriod_us) {
    const auto ns = static_cast<std::int64_t>(t) * 1000;
    record.simulator.push_back({base::LedgerEntry::Direction::kSent, kSensor, t, ns});
    casd::PacketInfo info{};
    info.message_id = kSensor;
    info.hil_time_usec = t;
    info.received = base::RunTime(std::chrono::nanoseconds(ns + 20'000));
    record.relay->simulator.received(info);
    const base::RunTime late(std::chrono::nanoseconds(ns + 60'000));
    passes(t) ? record.relay->controller.sent(info, late)
              : record.relay->controller.dropped(info, casd::DropCause{}, late);
  }
  stand_in_for_controller(record);
  return record;
}

RunRecord failed(RunRecord record, const char* why) {
  record.flight_failure = why;
  return record;
}

TEST_F(FirmwareFlightFigures, OfAMachineThatKeepsUpLeaveTheVerdictToTheFlight) {
  const auto all = [](std::uint64_t) { return true; };
  const Verdict verdict = judged(streamed(flown(), all));
  EXPECT_EQ(verdict.exit_code(), kExitPassed) << testing::PrintToString(verdict.failures);
  EXPECT_EQ(judged(streamed(failed(flown(), "it was disarmed"), all)).exit_code(),
            kExitLimitsMissed);
}

TEST_F(FirmwareFlightFigures, WithAGapAtThePortGiveNoVerdictOnACrash) {
  const auto with_gap = [](std::uint64_t t) { return t < 3'000'000 || t > 3'100'000; };
  EXPECT_EQ(judged(streamed(flown(), with_gap)).exit_code(), kExitPassed)
      << "not in the measured step";
  const Verdict verdict = judged(streamed(failed(flown(), "it was disarmed"), with_gap));
  EXPECT_EQ(verdict.exit_code(), kExitInvalid);
  EXPECT_TRUE(says(
      verdict, "the machine was too busy: no HIL_SENSOR came to the controller's port for 108 ms"))
      << testing::PrintToString(verdict.failures);
}

TEST_F(FirmwareFlightFigures, OfWhichCasdDroppedMoreThanOnePercentGiveNoVerdict) {
  const Verdict verdict =
      judged(streamed(flown(), [](std::uint64_t t) { return t / kPeriod_us % 50 != 0; }));
  EXPECT_EQ(verdict.exit_code(), kExitInvalid);
  EXPECT_TRUE(says(verdict, "HIL_SENSOR were dropped before the controller's port"))
      << testing::PrintToString(verdict.failures);
}

TEST_F(FirmwareFlightFigures, AreNotTheMachinesOnceAFaultHasBegunOrTheFirmwareIsSilent) {
  const auto ends = [](std::uint64_t t) { return t < 8'000'000; };
  RunRecord cut = failed(flown(), "the vehicle was disarmed during step 2 (hold)");
  cut.firmware->bench_faults = {{.name = "unplug", .begin = at(8), .end = {}}};
  EXPECT_EQ(judged(streamed(cut, ends)).exit_code(), kExitLimitsMissed);
  RunRecord dead = failed(flown(), "firmware was ended by signal 11");
  dead.firmware->fell_silent = at(8);
  EXPECT_EQ(judged(streamed(dead, ends)).exit_code(), kExitLimitsMissed);
}

TEST(FirmwareStream, IsNotMeasuredWhereAFaultCameFirst) {
  RunRecord record = flown();
  record.firmware->bench_faults = {{.name = "early", .begin = at(0.1), .end = {}}};
  EXPECT_FALSE(machine_window(record, {}));
  RunRecord nothing;
  nothing.firmware.emplace();
  EXPECT_FALSE(machine_window(nothing, {}));
}

TEST(FirmwareVersion, ThatIsTooOldOrNotToldIsNotFlown) {
  Firmware wanted;
  EXPECT_EQ(version_fault(wanted, ""), std::nullopt);
  wanted.least_version = "1.12";
  EXPECT_EQ(version_fault(wanted, "1.12.0"), std::nullopt);
  EXPECT_EQ(version_fault(wanted, "1.11.3"),
            "the firmware is v1.11.3, and firmware.least_version is 1.12");
  EXPECT_EQ(version_fault(wanted, ""),
            "the firmware did not tell its version within 20 s, and firmware.least_version is "
            "1.12");
  EXPECT_EQ(version_fault(wanted, "1.8.0"), std::nullopt) << "PX4's word for a tree without tags";
  EXPECT_EQ(version_fault(wanted, "0.0.0"), std::nullopt);
}

TEST(FirmwareParameters, HaveOneDigestWhateverTheirOrder) {
  const auto list = [](const char* text) { return nlohmann::json::parse(text); };
  const ParamDigest digest =
      digest_of(list(R"([{"name": "A", "value": 1}, {"name": "B", "value": 2.5}])"));
  EXPECT_EQ(digest.count, 2U);
  EXPECT_EQ(digest.sha256.size(), 64U);
  EXPECT_EQ(digest_of(list(R"([{"name": "B", "value": 2.5}, {"name": "A", "value": 1}])")).sha256,
            digest.sha256);
  EXPECT_NE(digest_of(list(R"([{"name": "A", "value": 2}, {"name": "B", "value": 2.5}])")).sha256,
            digest.sha256);
}

TEST(FirmwareSilence, IsNotWaitedForLong) {
  EXPECT_EQ(silence_fault({.heard = true, .heartbeat_age_s = 29}), std::nullopt);
  EXPECT_TRUE(silence_fault({.heard = true, .heartbeat_age_s = 31}));
  EXPECT_TRUE(silence_fault({}));
}

TEST(FirmwareLosses, AreThoseThatCasdCounted) {
  FirmwareRecord record;
  add_losses(nlohmann::json::parse(R"([
      {"tx": {"dropped": {"age": 2, "queue_full": 1}}, "rx": {"lost": 4}},
      {"tx": {"dropped": {"age": 0}}, "rx": {"lost": 5}}])"),
             record);
  EXPECT_EQ(record.dropped, 3U);
  EXPECT_EQ(record.lost, 9U);
}

}  // namespace
}  // namespace cas::hils
