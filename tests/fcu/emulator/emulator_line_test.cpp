// SPDX-License-Identifier: BSD-3-Clause
// The serial line of a running fcu_emulator, changed through its control socket.
#include <gtest/gtest.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "base/rpc/message.hpp"
#include "mavlink/common/heartbeat.hpp"
#include "mavlink/common/ping.hpp"
#include "mavlink/common/timesync.hpp"
#include "tests/fcu/support/emulator_fixture.hpp"
#include "tests/support/paths.hpp"

namespace cas::fcu {
namespace {

using namespace mavlink::common;  // NOLINT
using base::rpc::Json;
using test::EmulatorFixture;

class Line : public testing::Test {
 protected:
  /// Time from a PING to its answer, s.
  double round_trip() {
    const base::RunTime begin = base::steady_now();
    emulator_.until_ping<Ping>();
    return base::to_seconds(base::steady_now() - begin);
  }
  EmulatorFixture emulator_;
};

TEST_F(Line, WithoutSensorsTheEstimateIsNotReady) {
  const auto heartbeat = emulator_.next<Heartbeat>();
  ASSERT_TRUE(heartbeat);
  EXPECT_EQ(heartbeat->system_status, MavState::kBoot);
  EXPECT_FALSE(emulator_.call("fcu.status")["estimator_ready"].get<bool>());
}

TEST_F(Line, StatusAndFiguresAreToldByTheControlSocket) {
  emulator_.settle();
  const Json status = emulator_.call("fcu.status");
  EXPECT_FALSE(status["armed"].get<bool>());
  EXPECT_EQ(status["mode"], "HOLD");
  EXPECT_EQ(status["landed"], "on_ground");
  EXPECT_TRUE(status["estimator_ready"].get<bool>());
  const Json stats = emulator_.call("fcu.stats");
  EXPECT_GT(stats["received"]["HIL_SENSOR"].get<int>(), 1000);
  EXPECT_GT(stats["sent"]["HIL_CONTROLS"].get<int>(), 1000);
  EXPECT_EQ(stats["crc_errors"], 0);
  EXPECT_EQ(stats["line"]["preset"], "ideal");
  EXPECT_GE(stats["sensor_age_us"]["max"].get<double>(), 0);
  EXPECT_GT(stats["update_us"]["p50"].get<double>(), 0);
}

TEST_F(Line, ASlowByteClockMakesPacketsLate) {
  // 12 bytes of header and checksum and 14 of PING each way; nothing else is on the line upwards.
  emulator_.call("line.set", {{"baud", 2400}});
  constexpr double kByte_s = 10.0 / 2400;
  EXPECT_GT(round_trip(), 2 * 20 * kByte_s);
  emulator_.call("line.set", {{"preset", "baud_921600"}});
  EXPECT_EQ(emulator_.call("fcu.stats")["line"]["preset"], "baud_921600");
}

TEST_F(Line, ExtraDelayActsBothWays) {
  emulator_.call("line.set", {{"extra_delay_us", 60'000}});
  EXPECT_GT(round_trip(), 0.12);
}

TEST_F(Line, LossesAreCounted) {
  emulator_.call("line.set", {{"packet_loss", 1}});
  emulator_.send(Ping{1, 1, 0, 0});
  EXPECT_TRUE(cas::test::wait_until(
      [&] { return emulator_.call("fcu.stats")["line"]["up"]["lost"].get<int>() > 0; }));
  emulator_.call("line.set", {{"preset", "ideal"}});
  EXPECT_LT(round_trip(), 19);
}

TEST_F(Line, WrongSettingsAreRefusedInWords) {
  const auto refused = [&](const std::string& method, const Json& params, const char* word) {
    try {
      emulator_.call(method, params);
      ADD_FAILURE() << params;
    } catch (const base::rpc::CallError& error) {
      EXPECT_EQ(error.code(), base::rpc::kInvalidParams);
      EXPECT_NE(std::string(error.what()).find(word), std::string::npos) << error.what();
    }
  };
  refused("line.set", {{"preset", "baud_9"}}, "baud_9");
  refused("line.set", {{"bawd", 5}}, "bawd");
  refused("line.set", {{"bit_error_rate", 2}}, "bit_error_rate");
  refused("line.hangup", {{"ms", -5}}, "ms");
}

TEST_F(Line, ATakenControlSocketEndsTheProgramWithExitCode71) {
  cas::test::ChildProcess second(
      {cas::test::binary_dir() + "/bin/fcu_emulator", emulator_.config_file().string(), "--link",
       emulator_.link().string() + ".second", "--control", emulator_.control_socket().string()});
  EXPECT_EQ(second.wait_exit(), 71);
  EXPECT_NE(second.output().find("is in use by another program"), std::string::npos)
      << second.output();
}

TEST_F(Line, HangsUpAndComesBack) {
  ASSERT_TRUE(emulator_.next<Heartbeat>());
  emulator_.call("line.hangup", {{"ms", 100}});
  EXPECT_TRUE(cas::test::wait_until([&] {
    emulator_.read();
    return emulator_.hung_up();
  }));
  ASSERT_TRUE(emulator_.reopen());
  EXPECT_TRUE(emulator_.next<Heartbeat>());
  EXPECT_LT(round_trip(), 19);
}

TEST_F(Line, ComesBackWhenItsPlaceIsFreeAgain) {
  emulator_.call("line.hangup", {{"ms", 60'000}});
  ASSERT_TRUE(
      cas::test::wait_until([&] { return !std::filesystem::is_symlink(emulator_.link()); }));
  std::filesystem::create_directory(emulator_.link());
  emulator_.call("line.hangup", {{"ms", 0}});
  const auto complaints = [&] {
    const std::string output = emulator_.process().output();
    int count = 0;
    for (std::size_t at = 0; (at = output.find("stays down", at)) != std::string::npos; ++at) {
      ++count;
    }
    return count;
  };
  EXPECT_TRUE(cas::test::wait_until([&] { return complaints() > 0; }));
  EXPECT_FALSE(emulator_.call("fcu.status")["armed"].get<bool>());  // the program lives
  std::filesystem::remove(emulator_.link());
  ASSERT_TRUE(emulator_.reopen());
  EXPECT_TRUE(emulator_.next<Heartbeat>());
  EXPECT_EQ(complaints(), 1) << emulator_.process().output();
}

}  // namespace
}  // namespace cas::fcu
