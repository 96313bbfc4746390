// SPDX-License-Identifier: BSD-3-Clause
#include "hils/measure/strike_response.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <functional>
#include <limits>
#include <optional>
#include <span>
#include <string_view>
#include <utility>
#include <vector>

#include "casd/tlog/tlog_files.hpp"
#include "hils/measure/run_record.hpp"
#include "mavlink/common/heartbeat.hpp"
#include "mavlink/common/statustext.hpp"
#include "mavlink/common/sys_status.hpp"
#include "mavlink_gen/runtime/codec.hpp"
#include "tests/support/temporary_folder.hpp"

namespace cas::hils {
namespace {

using std::chrono::seconds;
using namespace mavlink::common;  // NOLINT: the file is about its messages

/// Arm, takeoff to 10 m, to 20 m north, land: from 0 to 1, 5, 15 and 25 s.
class Struck : public testing::Test {
 protected:
  Struck() {
    add(StepKind::kArm, 0, 1);
    add(StepKind::kTakeoff, 1, 5).altitude_m = 10;
    add(StepKind::kGoto, 5, 15).place_m = {20, 0, 10};
    add(StepKind::kLand, 15, 25);
  }
  FlightStep& add(StepKind kind, int begin, int end) {
    steps_.push_back({.kind = kind});
    stages_.push_back({.step = steps_.back(),
                       .begin = base::SimTime(seconds(begin)),
                       .end = base::SimTime(seconds(end)),
                       .accepted = base::SimTime(seconds(begin)),
                       .reference_m = {20, 0, 10}});
    return steps_.back();
  }
  void hang_over_the_start() {
    for (Stage& stage : stages_) stage.reference_m = {0, 0, 10};
  }
  static PoseSample planned(double t) {
    PoseSample sample;
    sample.pose.z_m = t < 1 ? 0 : t < 5 ? 2.5 * (t - 1) : t < 15 ? 10 : std::max(0.0, 25 - t);
    sample.pose.x_m = std::clamp(2 * (t - 5), 0.0, 20.0);
    return sample;
  }
  /// 100 samples a second of a path, from 0 to `until_s`, of a fault at 10 s.
  StrikeResponse response(const std::function<void(double, PoseSample&)>& path, double until_s = 30,
                          VehicleMessages messages = {}) {
    std::vector<PoseSample> truth;
    for (int i = 0; i <= static_cast<int>(100 * until_s); ++i) {
      PoseSample sample = planned(0.01 * i);
      sample.time_us = i * 10'000;
      path(0.01 * i, sample);
      if (!truth.empty()) {
        const Pose& before = truth.back().pose;
        sample.v_m_s = {(sample.pose.x_m - before.x_m) / 0.01,
                        (sample.pose.y_m - before.y_m) / 0.01,
                        (sample.pose.z_m - before.z_m) / 0.01};
      }
      truth.push_back(sample);
    }
    return strike_response({.strike_s = strike_s_,
                            .end_s = end_s_,
                            .fault = "test",
                            .stops_rotors = stops_rotors_,
                            .stages = stages_,
                            .steps = steps_,
                            .completed = completed_,
                            .truth = truth,
                            .messages = std::move(messages)});
  }

  std::vector<FlightStep> steps_;
  std::vector<Stage> stages_;
  bool completed_ = true;
  bool stops_rotors_ = false;
  double strike_s_ = 10;
  std::optional<double> end_s_;
};

TEST_F(Struck, WhatFliesAsPlannedIsNowhereOffAndCameToRest) {
  const StrikeResponse got = response([](double, PoseSample&) {});
  EXPECT_NEAR(got.farthest_m, 0, 1e-9);
  EXPECT_EQ(got.peak_tilt_deg, 0);
  EXPECT_FALSE(got.crashed);
  EXPECT_FALSE(got.incident);
  EXPECT_TRUE(got.at_rest);
  EXPECT_NEAR(got.rest_m, 10, 1e-9) << "struck halfway, landed at the end";
  EXPECT_FALSE(got.detected_s);
}

TEST_F(Struck, IsMeasuredFromTheLinesBetweenThePlacesOfThePlan) {
  const StrikeResponse got = response([](double t, PoseSample& sample) {
    if (t < 10 || t > 12) return;
    sample.pose.y_m = 3 * std::sin((t - 10) / 2 * M_PI);
    sample.pose.roll_rad = 0.5;
    sample.pose.pitch_rad = 0.5;
  });
  EXPECT_NEAR(got.farthest_m, 3, 1e-6);
  EXPECT_NEAR(got.peak_tilt_deg, std::acos(std::cos(0.5) * std::cos(0.5)) * 180 / M_PI, 1e-9);
}

TEST_F(Struck, OfAHoldIsMeasuredByItselfWhateverTheNextStepDoes) {
  steps_.clear();
  stages_.clear();
  add(StepKind::kTakeoff, 1, 5).altitude_m = 10;
  add(StepKind::kHold, 5, 15);
  add(StepKind::kTrajectory, 15, 20).trajectory.size_m = 4;
  hang_over_the_start();
  const StrikeResponse got = response(
      [](double t, PoseSample& sample) {
        const bool moves_off = t > 11 && t < 12;
        sample.pose.x_m = t > 16 ? 4 : moves_off ? 0.3 * std::sin((t - 11) * M_PI) : 0;
        if (t > 5) sample.pose.z_m = 10;
        sample.pose.pitch_rad = t > 16 ? 0.6 : moves_off ? 0.2 : 0;
      },
      20);
  ASSERT_TRUE(got.hold_farthest_m && got.hold_tilt_deg);
  EXPECT_NEAR(*got.hold_farthest_m, 0.3, 1e-3);
  EXPECT_NEAR(*got.hold_tilt_deg, 0.2 * 180 / M_PI, 1e-9);
  EXPECT_NEAR(got.peak_tilt_deg, 0.6 * 180 / M_PI, 1e-9);
  EXPECT_NEAR(got.farthest_m, 0.3, 1e-3) << "a trajectory's size is allowed in the trajectory";
}

TEST_F(Struck, MayStillFlyBackInTheStepAfterATrajectory) {
  steps_.clear();
  stages_.clear();
  add(StepKind::kTakeoff, 1, 5).altitude_m = 10;
  add(StepKind::kTrajectory, 5, 9).trajectory.size_m = 4;
  add(StepKind::kHold, 9, 15);
  add(StepKind::kHold, 15, 20);
  hang_over_the_start();
  const auto flown = [&](double off_from_s, double off_m) {
    return response(
        [=](double t, PoseSample& sample) {
          sample.pose.x_m = t > off_from_s ? off_m : 0;
          if (t > 5) sample.pose.z_m = 10;
        },
        20);
  };
  EXPECT_NEAR(flown(12, 4.5).farthest_m, 4.5, 1e-6) << "it stays there in the last hold";
  const StrikeResponse back = response(
      [](double t, PoseSample& sample) {
        sample.pose.x_m = t < 5 ? 0 : t < 12 ? 4 : 0.5;
        if (t > 5) sample.pose.z_m = 10;
      },
      20);
  EXPECT_NEAR(back.farthest_m, 0.5, 1e-6);
}

TEST_F(Struck, InNoHoldHasNoFiguresOfAHold) {
  const StrikeResponse got = response([](double, PoseSample&) {});
  EXPECT_FALSE(got.hold_farthest_m);
  EXPECT_FALSE(got.hold_tilt_deg);
}

TEST_F(Struck, WhatCameBeforeTheStrikeDoesNotCount) {
  const StrikeResponse got = response(
      [](double t, PoseSample& sample) {
        if (t > 8 && t < 9) sample.pose.y_m = 5 * std::sin((t - 8) * M_PI);
        if (t > 8 && t < 9) sample.pose.roll_rad = 1.5;
      },
      30, {.signs = {{.time_s = 9, .what = "'before'"}}, .armed = {{.time_s = 1, .armed = true}}});
  EXPECT_LT(got.farthest_m, 1e-9);
  EXPECT_EQ(got.peak_tilt_deg, 0);
  EXPECT_FALSE(got.detected_s);
  EXPECT_FALSE(got.incident);
  EXPECT_TRUE(got.armed_before);
  EXPECT_TRUE(got.armed_after);
}

TEST_F(Struck, AFallIsACrashAlsoInTheStepThatWasNotDone) {
  stages_.resize(3);  // the last one is under way
  completed_ = false;
  const StrikeResponse got = response([](double t, PoseSample& sample) {
    if (t <= 11) return;
    sample.pose.x_m = 12;
    sample.pose.z_m = std::max(0.0, 10 - 0.5 * 9.81 * (t - 11) * (t - 11));
  });
  EXPECT_TRUE(got.crashed);
  EXPECT_EQ(got.incident, IncidentKind::kGround);
  EXPECT_TRUE(got.at_rest);
  EXPECT_FALSE(got.completed);
  const StrikeResponse cut = response(
      [](double t, PoseSample& sample) {
        if (t > 11) sample.pose.z_m = 10 - 0.5 * 9.81 * (t - 11) * (t - 11);
      },
      12);
  EXPECT_TRUE(cut.crashed) << "still falling when the record ended";
  EXPECT_FALSE(cut.at_rest);
}

TEST_F(Struck, TheFirstSignDetectsAndTheFirstFailsafeReacts) {
  const VehicleMessages messages{
      .signs = {{.time_s = 9.5, .what = "'before'"},
                {.time_s = 10.4, .what = "health: GPS"},
                {.time_s = 12, .what = "LAND", .is_reaction = true},
                {.time_s = 13, .what = "TERMINATION", .is_reaction = true}},
      .armed = {{.time_s = 1, .armed = true}}};
  const StrikeResponse got = response([](double, PoseSample&) {}, 30, messages);
  ASSERT_TRUE(got.detected_s && got.reacted_s);
  EXPECT_NEAR(*got.detected_s, 0.4, 1e-9);
  EXPECT_EQ(got.detected_by, "health: GPS");
  EXPECT_NEAR(*got.reacted_s, 2, 1e-9);
  EXPECT_EQ(got.reaction, "LAND");
  EXPECT_TRUE(got.terminated);
}

TEST_F(Struck, DisarmingIsAReactionInTheAirAlone) {
  const VehicleMessages landed{
      .signs = {}, .armed = {{.time_s = 1, .armed = true}, {.time_s = 28, .armed = false}}};
  const StrikeResponse good = response([](double, PoseSample&) {}, 30, landed);
  EXPECT_FALSE(good.terminated);
  EXPECT_FALSE(good.reacted_s);
  const VehicleMessages dropped{
      .signs = {}, .armed = {{.time_s = 1, .armed = true}, {.time_s = 11, .armed = false}}};
  const StrikeResponse bad = response([](double, PoseSample&) {}, 30, dropped);
  EXPECT_TRUE(bad.terminated);
  EXPECT_NEAR(bad.reacted_s.value_or(0), 1, 1e-9);
  EXPECT_NEAR(bad.detected_s.value_or(0), 1, 1e-9);
}

TEST_F(Struck, AfterTheFlightThereIsNoVerdict) {
  EXPECT_FALSE(response([](double, PoseSample&) {}).no_verdict);
  strike_s_ = 25;
  EXPECT_EQ(response([](double, PoseSample&) {}).no_verdict,
            "never acted: it struck after the flight");
  strike_s_ = 40;
  EXPECT_EQ(response([](double, PoseSample&) {}).no_verdict,
            "never acted: it struck after the flight");
  add(StepKind::kDisarm, 25, 30);  // landed, and disarmed before the step asks for it
  strike_s_ = 28;
  const VehicleMessages disarmed{
      .signs = {}, .armed = {{.time_s = 1, .armed = true}, {.time_s = 27, .armed = false}}};
  EXPECT_EQ(response([](double, PoseSample&) {}, 30, disarmed).no_verdict,
            "never acted: it struck after the flight");
  add(StepKind::kArm, 30, 31);  // a second flight follows
  EXPECT_FALSE(response([](double, PoseSample&) {}, 35, disarmed).no_verdict);
}

TEST_F(Struck, KnowsWhetherItFlewAndWhetherItWasToBeArmed) {
  EXPECT_TRUE(response([](double, PoseSample&) {}).in_air);
  EXPECT_FALSE(response([](double, PoseSample&) {}).tried_to_arm) << "the strike came later";
  strike_s_ = 0;
  const StrikeResponse stayed = response([](double, PoseSample& sample) { sample.pose.z_m = 0; });
  EXPECT_FALSE(stayed.in_air);
  EXPECT_TRUE(stayed.tried_to_arm);
}

TEST_F(Struck, SignsCountUntilAHeartbeatAfterTheFaultsEnd) {
  end_s_ = 12;
  const auto sign_at = [](double time_s) {
    return VehicleMessages{.signs = {{.time_s = time_s, .what = "'Low battery'"}}, .armed = {}};
  };
  EXPECT_TRUE(response([](double, PoseSample&) {}, 30, sign_at(13)).detected_s);
  EXPECT_FALSE(response([](double, PoseSample&) {}, 30, sign_at(13.1)).detected_s);
  end_s_.reset();
  EXPECT_TRUE(response([](double, PoseSample&) {}, 30, sign_at(13.1)).detected_s);
}

TEST_F(Struck, SignsCountUntilTheEndOfTheFlight) {
  const auto told_at = [this](double time_s) {
    return response([](double, PoseSample&) {}, 30,
                    {.signs = {{.time_s = time_s, .what = "'Low battery'"}},
                     .armed = {{.time_s = 1, .armed = true}, {.time_s = 27, .armed = false}}})
        .detected_s.has_value();
  };
  EXPECT_TRUE(told_at(24.9));
  EXPECT_FALSE(told_at(25.1)) << "the last step is done";
  add(StepKind::kDisarm, 25, 29);
  EXPECT_TRUE(told_at(26.9));
  EXPECT_FALSE(told_at(27.1)) << "it is disarmed";
  strike_s_ = 0.5;
  EXPECT_TRUE(told_at(27.1)) << "struck on the ground";
}

/// Falls from 10 m at 11 s and lies on its side from 12.43 s on.
void fall(double t, PoseSample& sample) {
  if (t <= 11) return;
  sample.pose.x_m = 12;
  sample.pose.z_m = std::max(0.0, 10 - 0.5 * 9.81 * (t - 11) * (t - 11));
  if (sample.pose.z_m == 0) sample.pose.roll_rad = 1.5;
}

TEST_F(Struck, WhatComesAfterTheImpactDoesNotCount) {
  const VehicleMessages late{
      .signs = {{.time_s = 12.6, .what = "TERMINATION", .is_reaction = true}},
      .armed = {{.time_s = 1, .armed = true}, {.time_s = 12.7, .armed = false}}};
  const StrikeResponse got = response(fall, 30, late);
  EXPECT_TRUE(got.crashed);
  EXPECT_FALSE(got.terminated);
  EXPECT_FALSE(got.detected_s);
  EXPECT_FALSE(got.reacted_s);
  EXPECT_LT(got.peak_tilt_deg, 1);
  VehicleMessages in_time = late;
  in_time.armed.back().time_s = 12;
  EXPECT_TRUE(response(fall, 30, in_time).terminated);
}

TEST_F(Struck, RotorsThatStandStillInTheAirNeedNoWord) {
  const auto stop_at = [](double stop_s) {
    return [stop_s](double t, PoseSample& sample) {
      fall(t, sample);
      if (t < stop_s) std::ranges::fill(sample.omega_rad_s, 600);
    };
  };
  EXPECT_TRUE(response(stop_at(11.5)).terminated);
  EXPECT_FALSE(response(stop_at(12.6)).terminated) << "on the ground";
  EXPECT_FALSE(response(fall).terminated) << "they were not seen to turn";
  stops_rotors_ = true;
  EXPECT_FALSE(response(stop_at(11.5)).terminated) << "the fault did";
  const VehicleMessages said{
      .signs = {}, .armed = {{.time_s = 1, .armed = true}, {.time_s = 12, .armed = false}}};
  EXPECT_TRUE(response(stop_at(11.5), 30, said).terminated);
}

TEST_F(Struck, ABounceAfterTheFallIsNotTheAir) {
  const StrikeResponse got = response(
      [](double t, PoseSample& sample) {
        fall(t, sample);
        if (t > 12.5 && t < 12.8) sample.pose.z_m = 1;
      },
      30, {.signs = {}, .armed = {{.time_s = 1, .armed = true}, {.time_s = 12.6, .armed = false}}});
  EXPECT_FALSE(got.terminated);
}

TEST_F(Struck, ACrashCountsThoughOneCameBefore) {
  const StrikeResponse got = response([](double t, PoseSample& sample) {
    if (t > 8 && t < 8.2) sample.pose.roll_rad = 1.5;
    if (t > 11 && t < 11.2) sample.pose.roll_rad = 1.5;
  });
  EXPECT_EQ(got.incident, IncidentKind::kAttitude);
  EXPECT_TRUE(got.crashed);
}

TEST_F(Struck, AHoldIsMeasuredFromItsPlace) {
  stages_[2].step.kind = StepKind::kHold;  // at {20, 0, 10}, on the line of the plan
  const StrikeResponse got = response(
      [](double, PoseSample& sample) { sample.pose.x_m = std::min(sample.pose.x_m, 14.0); });
  EXPECT_NEAR(got.farthest_m, 10, 0.1) << "where it was struck";
}

TEST_F(Struck, WhatIsNoNumberIsInfinitelyFarAway) {
  const StrikeResponse got = response([](double t, PoseSample& sample) {
    if (t > 11) sample.pose.y_m = std::nan("");
  });
  EXPECT_TRUE(got.left_world);
  EXPECT_EQ(got.farthest_m, std::numeric_limits<double>::infinity());
}

/// A flight log of one vehicle.
class VehicleMessagesTest : public testing::Test {
 protected:
  template <class Message>
  void say(double time_s, const Message& message, mav::Source from = {1, 1}) {
    std::array<std::uint8_t, mav::kMaxPacketBytes> buffer{};
    const std::size_t size = mav::encode(message, from, sequence_++, buffer);
    casd::append_tlog_record(static_cast<std::uint64_t>(kEpoch_us + 1e6 * time_s),
                             std::span(buffer).first(size), log_);
  }
  void beat(double time_s, bool armed, MavState state, std::uint32_t mode) {
    Heartbeat m{.autopilot = MavAutopilot::kPx4, .base_mode = MavModeFlag::kCustomModeEnabled};
    if (armed) m.base_mode |= MavModeFlag::kSafetyArmed;
    m.custom_mode = mode;
    m.system_status = state;
    say(time_s, m);
  }
  void text(double time_s, MavSeverity severity, std::string_view words) {
    Statustext m{.severity = severity};
    std::copy_n(words.begin(), words.size(), m.text.begin());
    say(time_s, m);
  }
  void health(double time_s, MavSysStatusSensor healthy) {
    say(time_s, SysStatus{.onboard_control_sensors_health = healthy});
  }
  VehicleMessages read() {
    RunRecord record;
    record.flight_tlog = folder_.write(
        "flight.tlog", std::string_view(reinterpret_cast<const char*>(log_.data()), log_.size()));
    record.log_clock.add(static_cast<std::int64_t>(kEpoch_us), 0);
    return read_vehicle_messages(record);
  }

  static constexpr double kEpoch_us = 1.7e15;
  static constexpr std::uint32_t kHold = 0x03040000;
  static constexpr std::uint32_t kLand = 0x06040000;
  test::TemporaryFolder folder_;
  std::vector<std::uint8_t> log_;
  std::uint8_t sequence_ = 0;
};

TEST_F(VehicleMessagesTest, HasWarningsFallenFlagsAndTheModesOfAFailsafe) {
  using S = MavSysStatusSensor;
  beat(1, true, MavState::kActive, kHold);
  health(1, S::kGps | S::k3dMag | S::kPrearmCheck);
  text(2, MavSeverity::kInfo, "Take-off");
  health(3, S::k3dMag);  // in the air the arming checks' flag says nothing
  text(4, MavSeverity::kWarning, "Low battery");
  text(4.5, MavSeverity::kCritical, "Arming denied: no position estimate");
  text(4.6, MavSeverity::kCritical, "Mode change refused: no mission");
  text(4.7, MavSeverity::kWarning, "casd: this link may not inject failures");
  beat(5, true, MavState::kActive, kLand);  // commanded
  beat(6, true, MavState::kCritical, kLand);
  beat(7, true, MavState::kCritical, kLand);
  beat(8, false, MavState::kStandby, kLand);
  const VehicleMessages messages = read();
  ASSERT_EQ(messages.signs.size(), 3U);
  EXPECT_EQ(messages.signs[0].what, "health: GPS");
  EXPECT_NEAR(messages.signs[0].time_s, 3, 1e-6);
  EXPECT_EQ(messages.signs[1].what, "'Low battery'");
  EXPECT_EQ(messages.signs[2].what, "LAND");
  EXPECT_TRUE(messages.signs[2].is_reaction);
  EXPECT_NEAR(messages.signs[2].time_s, 6, 1e-6);
  ASSERT_EQ(messages.armed.size(), 2U);
  EXPECT_TRUE(messages.armed[0].armed);
  EXPECT_FALSE(messages.armed[1].armed);
}

TEST_F(VehicleMessagesTest, IsOfTheVehicleAlone) {
  Statustext other{.severity = MavSeverity::kCritical};
  say(1, other, {2, 1});
  say(1, other, {1, 50});
  EXPECT_TRUE(read().signs.empty());
}

}  // namespace
}  // namespace cas::hils
