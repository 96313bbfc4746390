// SPDX-License-Identifier: BSD-3-Clause
#include "mavlink_gen/services/vehicle_state.hpp"

#include <gtest/gtest.h>

#include "mavlink_gen/runtime/encode.hpp"
#include "mavlink_gen/services/command.hpp"
#include "mavlink_gen/services/vehicle_heartbeat.hpp"

namespace cas::mav::services {
namespace {

using namespace std::chrono_literals;
using namespace mavlink::common;

constexpr Source kVehicle{1, 1};

class State : public testing::Test {
 protected:
  template <class M>
  void hear(const M& message) {
    state_.on_packet(view_packet(encode_packet_(message)), now_);
  }
  void beat(std::uint32_t mode, MavModeFlag flags = {}) {
    Heartbeat heartbeat{.autopilot = MavAutopilot::kPx4,
                        .base_mode = MavModeFlag::kCustomModeEnabled | flags,
                        .custom_mode = mode};
    hear(heartbeat);
  }

  Time now_{100s};
  Encoder encode_packet_{kVehicle};
  VehicleState state_{kVehicle, now_};
};

TEST_F(State, NamesTheModeAndSaysWhetherItIsArmed) {
  beat(*custom_mode(ModeSet::kPx4, "hold"), MavModeFlag::kSafetyArmed);
  EXPECT_EQ(state_.mode(), "HOLD");
  EXPECT_TRUE(state_.armed());
  EXPECT_FALSE(state_.hil());
  now_ += 2s;
  EXPECT_EQ(state_.heartbeat_age(now_), 2s);
}

TEST_F(State, AModesCommandKeepsTheVehicleArmed) {
  beat(*custom_mode(ModeSet::kPx4, "HOLD"), MavModeFlag::kSafetyArmed);
  const VehicleCommand command = mode_command(state_, *custom_mode(ModeSet::kPx4, "LAND"));
  EXPECT_EQ(command.params[0], 129);
  EXPECT_EQ(command.params[1], 4);
  EXPECT_EQ(command.params[2], 6);
}

TEST_F(State, JoinsAStatusTextInChunks) {
  const std::string full(Statustext{}.text.size(), 'a');
  Statustext chunk{.id = 3};
  set_text(chunk.text, full);
  hear(chunk);
  EXPECT_TRUE(state_.status_texts().empty());
  chunk.chunk_seq = 1;
  set_text(chunk.text, "end\t");
  hear(chunk);
  ASSERT_EQ(state_.status_texts().size(), 1U);
  EXPECT_EQ(state_.status_texts()[0].text, full + "end");
}

TEST_F(State, BeginsAnewAfterSilenceAndWhenItsClockGoesBack) {
  hear(Attitude{.time_boot_ms = 60'000});
  now_ += 1s;
  hear(Attitude{.time_boot_ms = 61'000});
  EXPECT_EQ(state_.restarted_at(), Time{});
  hear(Attitude{.time_boot_ms = 500});
  EXPECT_EQ(state_.restarted_at(), now_);
  now_ += 4s;
  hear(Attitude{.time_boot_ms = 4'500});
  EXPECT_EQ(state_.restarted_at(), now_);
}

TEST(Vehicle, IsWhoSendsAHeartbeatAsAnAutopilot) {
  Heartbeat heartbeat{.autopilot = MavAutopilot::kPx4};
  EXPECT_TRUE(is_vehicle(kVehicle, heartbeat));
  heartbeat.type = MavType::kGcs;
  EXPECT_FALSE(is_vehicle(kVehicle, heartbeat));
  heartbeat = {.autopilot = MavAutopilot::kInvalid};
  EXPECT_FALSE(is_vehicle(kVehicle, heartbeat));
}

}  // namespace
}  // namespace cas::mav::services
