// SPDX-License-Identifier: BSD-3-Clause
// Recorded conversations with stock firmware, replayed through casd's vehicle state, doctor and the
// plan of a flight: they lead to the verdicts that the real flights had. Each scripted peer is held
// against the recording of the firmware that it stands for.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "casd/casctl/doctor/findings.hpp"
#include "casd/port/vehicle_json.hpp"
#include "casd/station/vehicle_commander.hpp"
#include "hils/flight/flight_plan.hpp"
#include "hils/programs/pilot_calls.hpp"
#include "mavlink/common/all.hpp"
#include "mavlink_gen/runtime/codec.hpp"
#include "tests/firmware/ardupilot_peer.hpp"
#include "tests/firmware/conversation.hpp"
#include "tests/firmware/px4_sitl_peer.hpp"
#include "tests/firmware/running_simulation.hpp"

namespace cas::test {
namespace {

namespace mv = mavlink::common;
using std::chrono::seconds;

/// casd's station, which hears what a vehicle said then.
class Listener {
 public:
  /// @return whether the vehicle is known
  bool hear(const Said& said) {
    now_ = said.at;
    const mav::PacketView packet = said.view();
    if (packet.source == mav::Source{254, 190}) return vehicle() != nullptr;
    commander_.on_packet(casd::LinkId{0}, packet, now_);
    return vehicle() != nullptr;
  }
  const casd::VehicleState* vehicle() const { return commander_.find(1); }
  std::string lack() const { return casd::position_lack(*vehicle(), now_); }
  nlohmann::json state() const {
    return casd::state_json(
        *vehicle(), [](casd::LinkId) { return std::string("fcu"); }, now_);
  }
  /// What doctor finds wrong with its readiness.
  std::string doctors_words() const {
    casctl::DoctorFacts facts;
    facts.after = {{"allow_not_hil", true}, {"vehicles", nlohmann::json::array({state()})}};
    casctl::Findings findings;
    casctl::check_readiness(facts, findings);
    std::string words;
    for (const casctl::Finding& finding : findings) {
      if (finding.health == casctl::Health::kBad) words += finding.what + "\n";
    }
    return words;
  }
  double elapsed_s() const { return base::to_seconds(now_.time_since_epoch()) - 100; }
  base::RunTime now() const { return now_; }

 private:
  casd::VehicleCommander commander_{
      {.ask_on_sight = false}, [](std::span<const std::uint8_t>, std::span<const casd::Path>) {}};
  base::RunTime now_{};
};

struct ReadyCase {
  const char* name;
  const char* file;
  double ready_s;  ///< it may be armed, at the latest, after the log's begin; 0: never
  std::vector<std::string> lacks{};  ///< words at the end of one that is never ready
};

class RecordedReadiness : public testing::TestWithParam<ReadyCase> {};

TEST_P(RecordedReadiness, IsNeverToldWhereTheFirmwareRefusedAndInTimeWhereItWasReady) {
  const ReadyCase& expected = GetParam();
  Listener casd;
  std::optional<double> ready_s;
  for (const Said& said : recorded(expected.file)) {
    if (!casd.hear(said)) continue;
    const mav::PacketView packet = said.view();
    const auto ack = mav::decode<mv::CommandAck>(packet);
    if (ack && ack->command == mv::MavCmd::kComponentArmDisarm &&
        ack->result != mv::MavResult::kAccepted) {
      EXPECT_NE(casd.lack(), "") << "it refused to arm at " << casd.elapsed_s() << " s";
      EXPECT_NE(casd.doctors_words(), "") << "doctor, at " << casd.elapsed_s() << " s";
    }
    if (!ready_s && casd.lack().empty()) ready_s = casd.elapsed_s();
  }
  if (expected.ready_s > 0) {
    ASSERT_TRUE(ready_s) << casd.lack();
    EXPECT_LE(*ready_s, expected.ready_s);
    EXPECT_EQ(casd.lack(), "") << "and so it stays";
    EXPECT_EQ(casd.doctors_words(), "");
    return;
  }
  EXPECT_FALSE(ready_s) << "after " << ready_s.value_or(0) << " s";
  for (const std::string& words : expected.lacks) {
    EXPECT_NE(casd.lack().find(words), std::string::npos) << casd.lack();
    EXPECT_NE(casd.doctors_words().find(words), std::string::npos) << casd.doctors_words();
  }
}

INSTANTIATE_TEST_SUITE_P(
    Of, RecordedReadiness,
    testing::Values(
        ReadyCase{"Px4V116AtRest", "px4_1.16_sitl_at_rest", 6.5},
        ReadyCase{"Px4V118AtRest", "px4_1.18_sitl_at_rest", 5.5},
        ReadyCase{"Px4V115InSoftware", "px4_1.15_sitl_hover", 5},
        ReadyCase{"Px4V116OnASerialLine", "px4_1.16_hitl_hover", 14.2},
        ReadyCase{"ArduCopter46", "arducopter_4.6_hover", 41.1},
        ReadyCase{"Px4WithoutGps", "px4_1.16_sitl_no_gps", 0, {"no velocity", "no GPS"}},
        ReadyCase{
            "Px4WithoutMagnetometer", "px4_1.16_sitl_no_magnetometer", 0, {"no magnetometer"}},
        ReadyCase{"Px4WithoutBarometer",
                  "px4_1.16_sitl_no_barometer",
                  0,
                  {"arming checks fail", "no barometer"}}),
    [](const auto& test) { return std::string(test.param.name); });

hils::FlightStep step(hils::StepKind kind, double timeout_s) {
  hils::FlightStep step{.kind = kind};
  step.timeout = base::from_seconds(timeout_s);
  return step;
}

/// Takeoff, hover, landing.
std::vector<hils::FlightStep> hover_steps(double altitude_m) {
  using hils::StepKind;
  std::vector<hils::FlightStep> steps{step(StepKind::kArm, 60), step(StepKind::kTakeoff, 30),
                                      step(StepKind::kHold, 30), step(StepKind::kLand, 60),
                                      step(StepKind::kDisarm, 30)};
  steps[1].altitude_m = altitude_m;
  steps[2].duration = seconds(5);
  return steps;
}

struct FlightCase {
  const char* name;
  const char* file;
  double altitude_m;  ///< of its takeoff
};

class RecordedFlight : public testing::TestWithParam<FlightCase> {};

TEST_P(RecordedFlight, IsDoneByThePlanThatItFlew) {
  Listener casd;
  constexpr hils::FirmwareHabits kHabits{
      .arms_early = true, .disarms_itself = seconds(5), .flies_setpoints = true};
  hils::FlightPlan plan(hover_steps(GetParam().altitude_m), 0, kHabits);
  for (const Said& said : recorded(GetParam().file)) {
    if (!casd.hear(said)) continue;
    const hils::VehicleReport report = plan.from_arming(hils::to_report(casd.state()));
    const base::SimTime now(casd.now().time_since_epoch());
    const auto command = plan.update(now, report);
    if (!command) continue;
    // The vehicle accepted when it did, and was armed by then.
    const bool early = command->kind == hils::StepKind::kArm && !report.armed;
    plan.on_outcome(now, early ? std::optional(hils::Refusal{"not yet"}) : std::nullopt);
  }
  ASSERT_FALSE(plan.failure()) << *plan.failure();
  EXPECT_TRUE(plan.done()) << plan.phase();
}

INSTANTIATE_TEST_SUITE_P(Of, RecordedFlight,
                         testing::Values(FlightCase{"Px4V115InSoftware", "px4_1.15_sitl_hover", 5},
                                         FlightCase{"Px4V116OnASerialLine", "px4_1.16_hitl_hover",
                                                    2.2},
                                         FlightCase{"ArduCopter46", "arducopter_4.6_hover", 5}),
                         [](const auto& test) { return std::string(test.param.name); });

/// Messages that PX4 v1.16.1 streams without being asked, in software and on a serial line.
const std::set<std::uint32_t> kOfPx4_1_16{
    0,  1,  4,   8,   22,  24,  29,  30,  31,  32,  33,  36,  42,  49,  74,  77,  83,    85,
    87, 93, 141, 147, 148, 230, 241, 242, 245, 253, 290, 291, 380, 410, 411, 436, 12901, 12904};

TEST(RecordedEvents, NameTheSensorThatIsMissing) {
  Listener casd;
  for (const Said& said : recorded("px4_1.16_sitl_no_magnetometer")) casd.hear(said);
  EXPECT_EQ(casd.vehicle()->failed_checks(), std::vector<std::string_view>{"no magnetometer"});
}

TEST(ScriptedPx4Manner, TellsNoMoreOfItsReadinessThanTheFirmware) {
  const Manner firmware = manner_of(recorded("px4_1.16_sitl_at_rest"));
  RunningSimulation simulation("px4_sitl.yaml", "mavlink_interface", "local: '127.0.0.1:0'");
  Px4SitlPeer peer(simulation.port(), {.release = Px4Release::k1_16});
  peer.pilot().ask_nothing();
  ASSERT_TRUE(peer.run_until([&] { return peer.px4().clock().time_since_epoch() > seconds(20); }));
  const Manner scripted = manner_of(peer.said());
  EXPECT_EQ(scripted.enables_checks, firmware.enables_checks);
  EXPECT_EQ(scripted.passes_checks, firmware.passes_checks);
  EXPECT_EQ(scripted.boots_uninit, firmware.boots_uninit);
  EXPECT_EQ(scripted.stands_still_const, firmware.stands_still_const);
  EXPECT_LE(scripted.estimator_hz, 1.2 * firmware.estimator_hz);
  for (const std::uint32_t message : scripted.messages) {
    EXPECT_TRUE(kOfPx4_1_16.contains(message)) << "message " << message;
  }
}

TEST(ScriptedArdupilotManner, TellsNoMoreThanItIsAskedFor) {
  const Manner firmware = manner_of(recorded("arducopter_4.6_hover"));
  RunningSimulation simulation("ardupilot.yaml", "ardupilot_json", "local: '127.0.0.1:0'");
  ArdupilotPeer silent(simulation.port());
  silent.pilot().ask_nothing();
  ASSERT_TRUE(
      silent.run_until([&] { return silent.ardupilot().clock().time_since_epoch() > seconds(5); }));
  EXPECT_EQ(manner_of(silent.said()).messages, std::set<std::uint32_t>{mv::Heartbeat::kId});
  ArdupilotPeer asked(simulation.port());
  ASSERT_TRUE(asked.run_until([&] { return asked.pilot().ended(); })) << asked.pilot().story();
  const Manner scripted = manner_of(asked.said());
  EXPECT_EQ(scripted.enables_checks, firmware.enables_checks);
  for (const std::uint32_t message : scripted.messages) {
    EXPECT_TRUE(firmware.messages.contains(message)) << "message " << message;
  }
}

}  // namespace
}  // namespace cas::test
