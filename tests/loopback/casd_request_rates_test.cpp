// SPDX-License-Identifier: BSD-3-Clause
// What the real casd asks a vehicle to send, by `request_rates` of its link.
#include <gtest/gtest.h>

#include <map>
#include <optional>
#include <string>

#include "tests/loopback/udp_autopilot.hpp"
#include "tests/support/child_process.hpp"
#include "tests/support/paths.hpp"
#include "tests/support/temporary_folder.hpp"

namespace cas::test {
namespace {

using namespace mavlink::common;

class CasdRequestRates : public testing::Test {
 protected:
  void start(const std::string& rates) {
    const std::string topology = folder.write(
        "topology.yaml",
        "schema: 1\ncommand_port: {port: 0, loopback_without_token: true}\n"
        "links:\n  - {name: net, type: udp_server, local: \"127.0.0.1:0\", request_rates: " +
            rates + "}\n");
    casd.emplace(std::vector<std::string>{binary_dir() + "/bin/casd", topology});
    const auto ready = casd->wait_ready();
    ASSERT_TRUE(ready) << casd->output();
    const std::size_t begin = ready->find(" net ") + 5;
    vehicle.socket.set_remote(port_of(ready->substr(begin, ready->find(' ', begin) - begin)));
  }
  /// How often the interval of a message was asked for, in the order of first requests.
  std::size_t asked(std::uint32_t id) const {
    return static_cast<std::size_t>(
        std::count_if(vehicle.commands.begin(), vehicle.commands.end(), [&](const auto& command) {
          return command.command == MavCmd::kSetMessageInterval &&
                 command.param1 == static_cast<float>(id);
        }));
  }
  float period_us(std::uint32_t id) const {
    for (const CommandLong& command : vehicle.commands) {
      const bool is = command.command == MavCmd::kSetMessageInterval &&
                      command.param1 == static_cast<float>(id);
      if (is) return command.param2;
    }
    return 0;
  }
  /// ATTITUDE tells the vehicle's clock.
  void tell_time(std::uint32_t time_boot_ms) {
    Attitude attitude;
    attitude.time_boot_ms = time_boot_ms;
    vehicle.socket.send(vehicle.encoder(attitude));
  }

  TemporaryFolder folder;
  std::optional<ChildProcess> casd;
  UdpAutopilot vehicle{MavAutopilot::kPx4};
};

TEST_F(CasdRequestRates, AreAskedForOnceAndAgainAfterARestart) {
  start("{ATTITUDE: 50, VFR_HUD: 0}");
  std::uint32_t time_ms = 60'000;
  const auto tell = [&] { tell_time(time_ms += 10); };
  ASSERT_TRUE(speaks_until(
      vehicle, [&] { return asked(VfrHud::kId) > 0; }, tell));
  EXPECT_EQ(period_us(Attitude::kId), 20'000);
  EXPECT_EQ(period_us(VfrHud::kId), -1);
  // A restart is one once it is no jump of the clock: 3 s after it was last asked.
  const base::RunTime later = base::steady_now() + std::chrono::seconds(4);
  ASSERT_TRUE(speaks_until(
      vehicle, [&] { return base::steady_now() > later; }, tell));
  EXPECT_EQ(asked(Attitude::kId), 1U);
  EXPECT_EQ(asked(VfrHud::kId), 1U);
  time_ms = 100;
  ASSERT_TRUE(speaks_until(
      vehicle, [&] { return asked(VfrHud::kId) > 1; }, tell));
  EXPECT_EQ(asked(Attitude::kId), 2U);
}

TEST_F(CasdRequestRates, AreRepeatedUntilAcknowledgedAndARefusalIsTold) {
  start("{ATTITUDE: 50}");
  vehicle.answers = false;
  ASSERT_TRUE(speaks_until(vehicle, [&] { return asked(Attitude::kId) == 2; }));
  vehicle.answers = true;
  vehicle.result = MavResult::kDenied;
  EXPECT_TRUE(speaks_until(vehicle, [&] {
    return casd->output().find("does not send message 30 at 50 Hz") != std::string::npos;
  })) << casd->output();
  EXPECT_EQ(asked(Attitude::kId), 3U);
}

TEST_F(CasdRequestRates, TakeThePlaceOfWhatAnArduPilotIsAskedForAnyway) {
  vehicle.kind = MavAutopilot::kArdupilotmega;
  start("{ATTITUDE: 50}");
  ASSERT_TRUE(speaks_until(vehicle, [&] { return asked(Attitude::kId) > 0; }));
  EXPECT_EQ(period_us(Attitude::kId), 20'000);
  EXPECT_EQ(asked(Attitude::kId), 1U);
  EXPECT_EQ(asked(SysStatus::kId), 1U);
}

TEST_F(CasdRequestRates, OfAMessageThatIsNoneAreRefusedWithTheirPlace) {
  const std::string topology =
      folder.write("t.yaml",
                   "schema: 1\nlinks:\n  - {name: a, type: udp, local: \"127.0.0.1:0\",\n"
                   "     request_rates: {ATITUDE: 50}}\n");
  ChildProcess check({binary_dir() + "/bin/casd", "--check", topology});
  EXPECT_EQ(check.wait_exit(), 78);
  EXPECT_NE(check.output().find("t.yaml:4: links[0].request_rates"), std::string::npos)
      << check.output();
  EXPECT_NE(check.output().find("ATITUDE"), std::string::npos) << check.output();
}

}  // namespace
}  // namespace cas::test
