// SPDX-License-Identifier: BSD-3-Clause
#include "hils/flight/flight_loop.hpp"

#include <gtest/gtest.h>

#include <chrono>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace cas::hils {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

base::SimTime at(base::Duration since_start) { return base::SimTime(since_start); }

/// Notes what the loop has it do.
class ScriptedBench final : public FlightBench {
 public:
  base::SimTime look() override {
    note("look");
    return now;
  }
  Motion truth(std::size_t) const override { return {.p_m = {1, 2, 3}}; }
  std::optional<VehicleReport> report(std::size_t vehicle) override { return reports[vehicle]; }
  void before_steps(Flight&, base::SimTime) override { note("before"); }
  void after_steps(Flight&, base::SimTime) override { note("after"); }
  void tell_phase(std::string_view phase) override { note("phase " + std::string(phase)); }
  void play(const Flight&, const BenchFault& fault, bool begins) override {
    note((begins ? "begin " : "end ") + fault.name);
  }
  void show(base::SimTime, const FlightPlan&, const VehicleReport&) override { note("show"); }
  void give(Flight&, std::size_t vehicle, const FlightStep& step, Answer answer) override {
    note("give " + std::string(to_string(step.kind)) + " to " + std::to_string(vehicle));
    answers.push_back(std::move(answer));
  }

  /// What was noted since the last call.
  std::vector<std::string> acts() { return std::exchange(acts_, {}); }

  base::SimTime now{};
  std::vector<std::optional<VehicleReport>> reports;
  std::vector<Answer> answers;

 private:
  void note(std::string act) { acts_.push_back(std::move(act)); }

  std::vector<std::string> acts_;
};

BenchFault fault_at(base::Duration begin, base::Duration lasting) {
  return {.name = "cut",
          .at = at(begin),
          .when = std::nullopt,
          .lasting = lasting,
          .kind = UnplugFault{}};
}

class FlightLoopTest : public testing::Test {
 protected:
  static Flight flight(const std::vector<FlightStep>& steps, std::vector<BenchFault> faults = {},
                       std::size_t vehicles = 1) {
    VehicleNames names;
    for (std::size_t i = 0; i < vehicles; ++i) names.push_back("iris" + std::to_string(i));
    return {names, steps, std::vector<double>(vehicles), std::move(faults)};
  }

  using Acts = std::vector<std::string>;
  const VehicleReport disarmed_{.heard = true, .on_ground = true};
  const VehicleReport armed_{.heard = true, .armed = true, .on_ground = true};
  const std::vector<FlightStep> arm_{{.kind = StepKind::kArm}};
  ScriptedBench bench_;
};

TEST_F(FlightLoopTest, TakesItsActsInTheSameOrderInEachTurn) {
  bench_.reports = {disarmed_};
  FlightLoop loop(flight(arm_, {fault_at({}, seconds(1))}), bench_);
  EXPECT_TRUE(loop.turn());
  EXPECT_EQ(bench_.acts(),
            Acts({"look", "before", "phase arm", "after", "begin cut", "show", "give arm to 0"}));
  EXPECT_EQ(loop.flight().vehicles[0].truth->p_m.z(), 3);
}

TEST_F(FlightLoopTest, TakesAnAnswerAtOnceOrLater) {
  bench_.reports = {disarmed_};
  FlightLoop loop(flight(arm_), bench_);
  loop.turn();
  bench_.now = at(milliseconds(50));
  EXPECT_FALSE(loop.turn()) << "the answer has not come";
  bench_.answers[0](at(milliseconds(70)), Refusal{"not yet"});
  bench_.now = at(milliseconds(100));
  EXPECT_FALSE(loop.turn()) << "a refused command waits for a second";
  bench_.now = at(milliseconds(1100));
  EXPECT_TRUE(loop.turn());
  bench_.answers[1](at(milliseconds(1120)), std::nullopt);
  bench_.reports = {armed_};
  bench_.now = at(milliseconds(1200));
  bench_.acts();
  EXPECT_FALSE(loop.turn());
  EXPECT_EQ(bench_.acts(), Acts({"look", "before", "phase done", "after"}));
  ASSERT_EQ(loop.flight().plan.plan(0).stages().size(), 1U);
  EXPECT_EQ(loop.flight().plan.plan(0).stages()[0].accepted, at(milliseconds(1120)));
}

TEST_F(FlightLoopTest, WaitsForAVehicleOutOfSightWhileFaultsGoOn) {
  bench_.reports = {disarmed_, std::nullopt};
  FlightLoop loop(flight(arm_, {fault_at({}, milliseconds(50))}, 2), bench_);
  EXPECT_FALSE(loop.turn());
  EXPECT_EQ(bench_.acts(), Acts({"look", "before", "begin cut", "show"}));
  bench_.now = at(milliseconds(50));
  EXPECT_FALSE(loop.turn());
  EXPECT_EQ(bench_.acts(), Acts({"look", "before", "end cut", "show"}));
  bench_.reports[1] = disarmed_;
  EXPECT_TRUE(loop.turn());
  EXPECT_EQ(bench_.answers.size(), 2U);
}

TEST_F(FlightLoopTest, FliesToTheEndOfThePlan) {
  bench_.reports = {armed_};
  FlightLoop loop(flight({{.kind = StepKind::kHold, .duration = seconds(1), .measure = true}}),
                  bench_);
  int waits = 0;
  loop.fly([&](bool commanded) {
    EXPECT_FALSE(commanded);
    ++waits;
    bench_.now += milliseconds(500);
  });
  EXPECT_EQ(waits, 2);
  EXPECT_TRUE(loop.flight().plan.ended());
  EXPECT_TRUE(loop.flight().plan.plan(0).measured());
}

}  // namespace
}  // namespace cas::hils
