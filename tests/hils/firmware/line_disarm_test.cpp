// SPDX-License-Identifier: BSD-3-Clause
#include "hils/firmware/line_disarm.hpp"

#include <gmock/gmock.h>

#include <atomic>
#include <chrono>
#include <string>
#include <thread>

#include "mavlink/common/command_long.hpp"
#include "mavlink/common/heartbeat.hpp"
#include "mavlink_gen/runtime/codec.hpp"
#include "tests/support/pty_pair.hpp"

namespace cas::hils {
namespace {

namespace mv = mavlink::common;

constexpr mav::Source kVehicle{7, 1};

/// An armed autopilot at the other end of a line. Another one, which is disarmed, speaks there too.
class Autopilot {
 public:
  /// @param obeys  whether a forced disarm disarms it
  explicit Autopilot(bool obeys) : obeys_(obeys) {}
  const std::string& line() const { return line_.slave(); }
  bool is_armed() const { return is_armed_; }

 private:
  void live(const std::stop_token& end) {
    while (!end.stop_requested()) {
      line_.read(heard_);
      for (; !heard_.packets().empty(); heard_.packets().pop_front())
        hear(heard_.packets().front());
      tell(kVehicle, is_armed_);
      tell({8, 1}, false);
      std::this_thread::sleep_for(std::chrono::milliseconds(10));  // the period of its HEARTBEAT
    }
  }

  void hear(const test::PacketStream::Packet& packet) {
    const auto command = mav::decode<mv::CommandLong>(packet.view());
    if (!command || command->target_system != kVehicle.system) return;
    if (command->command != mv::MavCmd::kComponentArmDisarm || command->param1 != 0) return;
    if (obeys_ && command->param2 == 21196) is_armed_ = false;
  }

  void tell(mav::Source source, bool armed) {
    mv::Heartbeat beat;
    beat.autopilot = mv::MavAutopilot::kArdupilotmega;
    if (armed) beat.base_mode = mv::MavModeFlag::kSafetyArmed;
    line_.write(mav::Encoder(source)(beat));
  }

  test::PtyPair line_;
  test::PacketStream heard_;
  bool obeys_;
  std::atomic<bool> is_armed_ = true;
  std::jthread life_{[this](const std::stop_token& end) { live(end); }};
};

TEST(LineDisarm, EndsWhenTheVehicleSaysThatItIsDisarmed) {
  const Autopilot vehicle(true);
  EXPECT_EQ(disarm_by_line({.path = vehicle.line()}, kVehicle), std::nullopt);
  EXPECT_FALSE(vehicle.is_armed());
}

TEST(LineDisarm, SaysThatAVehicleMayStillBeArmed) {
  const Autopilot vehicle(false);
  EXPECT_EQ(disarm_by_line({.path = vehicle.line()}, kVehicle),
            "on " + vehicle.line() + " it does not say that it is disarmed");
}

TEST(LineDisarm, NamesALineThatIsGone) {
  const auto fault = disarm_by_line({.path = "/dev/cas-no-such-line"}, kVehicle);
  EXPECT_THAT(fault.value_or(""), testing::HasSubstr("/dev/cas-no-such-line"));
}

}  // namespace
}  // namespace cas::hils
