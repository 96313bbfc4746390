// SPDX-License-Identifier: BSD-3-Clause
#include "hils/firmware/hitl_stream.hpp"

#include <gtest/gtest.h>

#include <functional>
#include <string>

#include "base/measure/ledger.hpp"
#include "casd/counters/link_ledger.hpp"
#include "hils/firmware/firmware_verdict.hpp"
#include "mavlink/common/hil_sensor.hpp"
#include "tests/support/temporary_folder.hpp"

namespace cas::hils {
namespace {

using std::chrono::seconds;
constexpr std::uint32_t kSensor = mavlink::common::HilSensor::kId;
constexpr std::uint64_t kPeriod_us = 4000;

base::SimTime at(int s) { return base::SimTime(seconds(s)); }

/// Up from 2 s, held from 5 to 15 s, down to 20 s.
FirmwareFigures flown() {
  FirmwareFigures figures;
  const auto add = [&](StepKind kind, int begin, int end) {
    Stage stage;
    stage.step.kind = kind;
    stage.step.measure = kind == StepKind::kHold;
    stage.begin = at(begin);
    stage.end = at(end);
    figures.stages.push_back(stage);
  };
  add(StepKind::kTakeoff, 2, 5);
  add(StepKind::kHold, 5, 15);
  add(StepKind::kLand, 15, 20);
  return figures;
}

/// Ledgers of 22 s of HIL_SENSOR at 250 Hz, of which casd's port gets those that `passes` lets.
struct Ledgers {
  explicit Ledgers(const std::function<bool(std::uint64_t time_us)>& passes) {
    base::PacketLedger simulator;
    casd::LinkLedger in;
    casd::LinkLedger out;
    for (std::uint64_t t = kPeriod_us; t < 22'000'000; t += kPeriod_us) {
      const auto ns = static_cast<std::int64_t>(t) * 1000;
      simulator.sent(kSensor, t, base::RunTime(std::chrono::nanoseconds(ns)));
      casd::PacketInfo info{};
      info.message_id = kSensor;
      info.hil_time_usec = t;
      info.received = base::RunTime(std::chrono::nanoseconds(ns + 20'000));
      in.received(info);
      const base::RunTime late(std::chrono::nanoseconds(ns + 60'000));
      passes(t) ? out.sent(info, late) : out.dropped(info, casd::DropCause{}, late);
    }
    simulator.write(places.simulator_ledger());
    casd::write_link_ledgers(places.casd_ledger(), {{"sim", &in}, {"fcu", &out}});
  }

  test::TemporaryFolder folder;
  FirmwarePlaces places{.out = folder.path(), .run = folder.path(), .sockets = folder.path()};
};

Verdict judged(const Ledgers& ledgers, FirmwareFigures figures) {
  figures.stream = measure_hitl_stream({}, ledgers.places, figures);
  EXPECT_TRUE(figures.stream);
  return judge({}, figures);
}

TEST(HitlStream, OfAMachineThatKeepsUpLeavesTheVerdictToTheFlight) {
  const Ledgers ledgers([](std::uint64_t) { return true; });
  EXPECT_EQ(judged(ledgers, flown()).exit_code(), kExitPassed);
  FirmwareFigures fallen = flown();
  fallen.flight_failure = "the vehicle was disarmed during step 2 (hold)";
  EXPECT_EQ(judged(ledgers, fallen).exit_code(), kExitLimitsMissed);
}

TEST(HitlStream, WithAGapAtThePortGivesNoVerdictOnACrash) {
  const Ledgers ledgers([](std::uint64_t t) { return t < 17'000'000 || t > 17'100'000; });
  EXPECT_EQ(judged(ledgers, flown()).exit_code(), kExitPassed) << "not in the measured step";
  FirmwareFigures fallen = flown();
  fallen.flight_failure = "the vehicle was disarmed during step 3 (land)";
  const Verdict verdict = judged(ledgers, fallen);
  EXPECT_EQ(verdict.exit_code(), kExitInvalid);
  EXPECT_NE(verdict.failures.front().find("the machine was too busy: no HIL_SENSOR came to the "
                                          "controller's port for 108 ms"),
            std::string::npos)
      << verdict.failures.front();
}

TEST(HitlStream, OfWhichCasdDroppedMoreThanOnePercentGivesNoVerdict) {
  const Ledgers ledgers([](std::uint64_t t) { return t / kPeriod_us % 50 != 0; });
  const Verdict verdict = judged(ledgers, flown());
  EXPECT_EQ(verdict.exit_code(), kExitInvalid);
  EXPECT_NE(verdict.failures.front().find("HIL_SENSOR were dropped before the controller's port"),
            std::string::npos)
      << verdict.failures.front();
}

TEST(HitlStream, IsNotTheMachinesOnceAFaultHasBegunOrTheFirmwareIsSilent) {
  const Ledgers ledgers([](std::uint64_t t) { return t < 8'000'000; });
  FirmwareFigures cut = flown();
  cut.bench_faults = {{.name = "unplug", .begin = at(8), .end = {}}};
  cut.flight_failure = "the vehicle was disarmed during step 2 (hold)";
  EXPECT_EQ(judged(ledgers, cut).exit_code(), kExitLimitsMissed);
  FirmwareFigures dead = flown();
  dead.fell_silent = at(8);
  dead.flight_failure = "firmware was ended by signal 11";
  EXPECT_EQ(judged(ledgers, dead).exit_code(), kExitLimitsMissed);
}

TEST(HitlStream, OfACasdThatAFaultKilledIsJudgedAtTheSimulatorAlone) {
  const Ledgers ledgers([](std::uint64_t t) { return t > 10'000'000; });
  FirmwareFigures figures = flown();
  figures.bench_faults = {{.name = "restart", .begin = at(9), .end = at(10)}};
  FirmwareScenario scenario;
  BenchFault& fault = scenario.faults.bench.emplace_back();
  fault.kind = RestartFault{};
  figures.stream = measure_hitl_stream(scenario, ledgers.places, figures);
  ASSERT_TRUE(figures.stream);
  EXPECT_EQ(judge({}, figures).exit_code(), kExitPassed);
  figures.stream->pace.worst_stall_ms = 60;
  EXPECT_EQ(judge({}, figures).exit_code(), kExitInvalid);
}

TEST(HitlStream, IsNotMeasuredWhereAFaultCameFirst) {
  FirmwareFigures figures = flown();
  figures.bench_faults = {{.name = "early", .begin = at(1), .end = {}}};
  EXPECT_FALSE(machine_window(figures));
  EXPECT_FALSE(machine_window({}));
}

}  // namespace
}  // namespace cas::hils
