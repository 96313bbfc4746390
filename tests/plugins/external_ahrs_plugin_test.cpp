// SPDX-License-Identifier: BSD-3-Clause
// The plugin as an autopilot sees it: over its pseudo-terminal, by a scripted driver.
#include <fcntl.h>
#include <gmock/gmock.h>
#include <unistd.h>

#include <cmath>
#include <cstring>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "base/earth/frames.hpp"
#include "base/os/descriptor.hpp"
#include "base/os/serial_settings.hpp"
#include "tests/plugins/plugin_harness.hpp"
#include "tests/plugins/vector_nav_driver.hpp"
#include "tests/support/pty_pair.hpp"
#include "tests/support/refusal.hpp"
#include "tests/support/temporary_folder.hpp"
#include "tests/support/wait_until.hpp"

namespace cas::sim {
namespace {

using std::chrono::microseconds;
using std::chrono::seconds;
using test::arducopter_457;
using test::arducopter_462;
using test::value_at;
using test::VectorNavDriver;
using testing::HasSubstr;

constexpr base::Duration kStep = microseconds(1250);

/// A vehicle with sensors whose autopilot's driver reads the unit's line in each step.
class ExternalAhrs : public testing::Test {
 protected:
  ExternalAhrs() {
    harness_.add("imu", "{rate_hz: 400, gyro_stddev_deg_s: 0.1, accel_stddev_m_s2: 0.02}");
    harness_.add("gps",
                 "{rate_hz: 5, position_stddev_m: 0.1, velocity_stddev_m_s: 0.05, eph_m: 0.9, "
                 "epv_m: 1.2, satellites: 12}");
    harness_.add("magnetometer", "{rate_hz: 100, stddev_gauss: 0.001}");
    harness_.add("barometer", "{rate_hz: 50, stddev_pa: 1}");
  }

  void start(const std::string& keys = "") {
    const std::string link = (folder_.path() / "ahrs").string();
    plugin_ = &harness_.add("external_ahrs", "{pty: " + link + keys + "}");
    line_ = base::Descriptor(::open(link.c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC));
    ASSERT_TRUE(line_);
  }

  void send(const std::string& text) {
    ASSERT_EQ(::write(line_.get(), text.data(), text.size()), static_cast<ssize_t>(text.size()));
  }

  void run(base::Duration time, VectorNavDriver& driver) {
    for (base::Duration done{}; done < time; done += kStep) {
      if (const std::string line = driver.to_send(); !line.empty()) send(line);
      harness_.step();
      std::array<std::uint8_t, 4096> buffer;
      const ssize_t size = ::read(line_.get(), buffer.data(), buffer.size());
      if (size > 0) driver.feed(std::span(buffer).first(static_cast<std::size_t>(size)));
    }
  }

  nlohmann::json figures() const { return nlohmann::json::parse(plugin_->stats_json()); }

  test::TemporaryFolder folder_;
  test::PluginHarness harness_{kStep};
  Plugin* plugin_ = nullptr;
  base::Descriptor line_;
};

TEST_F(ExternalAhrs, GivesArducopter462ItsSensors) {
  harness_.world.body.q_WB = base::q_WB_from_q_ND(base::quaternion_rpy(0.1, 0.05, 1.0));
  harness_.world.body.p_WB = {10, 20, 30};
  start();
  VectorNavDriver driver = arducopter_462();
  run(std::chrono::milliseconds(100), driver);
  ASSERT_TRUE(driver.done());
  EXPECT_EQ(driver.answers.size(), 8U);
  EXPECT_EQ(driver.answers[3], test::nmea_line("VNRRG,01,VN-200"));
  driver.received.clear();
  const nlohmann::json lacking = figures()["without_sample"];
  run(seconds(2), driver);
  EXPECT_EQ(driver.bad, 0U);
  EXPECT_EQ(driver.received[82].size(), 800U);
  EXPECT_EQ(driver.received[104].size(), 100U);
  EXPECT_EQ(driver.received[110].size(), 10U);

  // Each inertial sample is the newest: the stamps are 2.5 ms apart.
  const auto& imu = driver.received[82];
  for (std::size_t i = 1; i < imu.size(); ++i) {
    ASSERT_EQ(value_at<std::uint64_t>(imu[i], 4) - value_at<std::uint64_t>(imu[i - 1], 4),
              2'500'000U);
  }
  EXPECT_NEAR(value_at<float>(imu.back(), 76), 97.0, 3.0) << "kPa at some 520 m";
  const std::vector<std::uint8_t>& ins = driver.received[104].back();
  EXPECT_NEAR(value_at<float>(ins, 16), 1.0 * 180 / M_PI, 1e-3);
  EXPECT_NEAR(value_at<float>(ins, 24), 0.1 * 180 / M_PI, 1e-3);
  EXPECT_NEAR(value_at<double>(ins, 74), test::kHome.alt_m + 30, 1e-6);
  const std::vector<std::uint8_t>& fix = driver.received[110].back();
  EXPECT_EQ(fix[24], 12) << "satellites";
  EXPECT_EQ(fix[25], 3);
  EXPECT_NEAR(value_at<double>(fix, 26), test::kHome.lat_deg, 1e-3);

  const nlohmann::json all = figures();
  EXPECT_EQ(all["dropped"], 0);
  EXPECT_EQ(all["late"], 0);
  EXPECT_EQ(all["without_sample"], lacking) << "before the first barometer sample alone";
  EXPECT_EQ(all["crc_errors"], 0);
  EXPECT_EQ(all["rates_hz"], nlohmann::json::parse("[400, 50, 5]"));
  EXPECT_EQ(all["asked"].size(), 8U);
}

TEST_F(ExternalAhrs, GivesArducopter457ItsSensorsAsAVn300) {
  start(", model: VN-300, solution: sensors");
  VectorNavDriver driver = arducopter_457();
  run(std::chrono::milliseconds(100), driver);
  ASSERT_TRUE(driver.done());
  driver.received.clear();
  run(seconds(2), driver);
  EXPECT_EQ(driver.bad, 0U);
  EXPECT_EQ(driver.received[170].size(), 800U);
  EXPECT_EQ(driver.received[92].size(), 10U);
  const std::vector<std::uint8_t>& fix = driver.received[92].back();
  EXPECT_EQ(fix[89], 3) << "a second receiver with a fix";
  EXPECT_EQ(figures()["dropped"], 0);
}

TEST_F(ExternalAhrs, SurvivesGarbageAndCountsIt) {
  start();
  VectorNavDriver driver = arducopter_462();
  send(std::string("\xFA\x01\xFF\x80", 4) + "$VNRRG,01*00\r\n" + "noise");
  harness_.step();
  std::array<char, 256> answer;
  ASSERT_GT(::read(line_.get(), answer.data(), answer.size()), 0);
  run(std::chrono::milliseconds(200), driver);
  EXPECT_TRUE(driver.done());
  EXPECT_EQ(figures()["crc_errors"], 1);
  EXPECT_EQ(figures()["garbage_bytes"], 9);
  EXPECT_GT(driver.received[82].size(), 10U);
}

TEST_F(ExternalAhrs, WritesNothingOldToADriverThatDoesNotRead) {
  start();
  VectorNavDriver driver = arducopter_462();
  run(std::chrono::milliseconds(100), driver);
  // Nobody reads: in real time, for the kernel passes bytes on by a thread of its own.
  ASSERT_TRUE(test::wait_until([&] {
    harness_.step();
    return figures()["reader_full"] > 20;
  }));
  std::array<std::uint8_t, 4096> buffer;
  const ssize_t waiting = ::read(line_.get(), buffer.data(), buffer.size());
  ASSERT_GT(waiting, 0);
  EXPECT_LE(waiting, 1024 + 296) << "the limit, and the packets of one step";
  driver.feed(std::span(buffer).first(static_cast<std::size_t>(waiting)));
  driver.received.clear();
  run(std::chrono::milliseconds(50), driver);
  EXPECT_EQ(driver.bad, 0U) << "no packet was torn";
  EXPECT_GE(driver.received[82].size(), 18U);
}

TEST_F(ExternalAhrs, ACutLinePassesNothingAndThenGoesOn) {
  harness_.add("fault", "{faults: [{at_s: 0.2, for_s: 0.1, disconnect: external_ahrs}]}");
  start();
  VectorNavDriver driver = arducopter_462();
  run(std::chrono::milliseconds(202), driver);
  driver.received.clear();
  send(test::nmea_line("VNASY,0"));
  run(std::chrono::milliseconds(98), driver);
  EXPECT_LE(driver.received[82].size(), 1U);
  EXPECT_EQ(figures()["running"], true) << "a line of the driver into the cut is lost";
  EXPECT_NEAR(figures()["cut_off"].get<int>(), 45, 2) << "40 inertial samples, 5 solutions";
  driver.received.clear();
  run(std::chrono::milliseconds(100), driver);
  EXPECT_NEAR(static_cast<double>(driver.received[82].size()), 40, 1);
  EXPECT_EQ(driver.bad, 0U) << "no packet was torn";
}

TEST_F(ExternalAhrs, ARunFromZeroDoesNotTurnTheUnitsTimeBack) {
  start();
  VectorNavDriver driver = arducopter_462();
  run(std::chrono::milliseconds(200), driver);
  const auto before = value_at<std::uint64_t>(driver.received[82].back(), 4);
  harness_.reset();
  driver.received.clear();
  run(std::chrono::milliseconds(200), driver);
  ASSERT_FALSE(driver.received[82].empty()) << "the board does not ask again";
  EXPECT_GT(value_at<std::uint64_t>(driver.received[82].front(), 4), before);
}

TEST_F(ExternalAhrs, OpensADeviceThatAProgramOffersAndNoOther) {
  const std::filesystem::path link = folder_.path() / "board";
  test::PtyPair board(link);
  Plugin& plugin = harness_.add("external_ahrs", "{device: " + link.string() + ", baud: 460800}");
  board.write(std::span(reinterpret_cast<const std::uint8_t*>("$VNRRG,01*72\r\n"), 14));
  harness_.step();
  std::array<char, 64> answer{};
  ASSERT_GT(::read(board.master(), answer.data(), answer.size()), 0);
  EXPECT_EQ(std::string(answer.data()), test::nmea_line("VNRRG,01,VN-200"));
  EXPECT_THAT(plugin.stats_json(), HasSubstr("serial "));

  test::PtyPair stranger;
  test::PluginHarness other(kStep);
  EXPECT_THAT(
      test::refusal([&] { other.add("external_ahrs", "{device: " + stranger.slave() + "}"); }),
      HasSubstr("no program of CAS offers"));
}

TEST_F(ExternalAhrs, WaitsForADeviceThatIsNotThereYet) {
  const std::filesystem::path link = folder_.path() / "later";
  plugin_ = &harness_.add("external_ahrs", "{device: " + link.string() + "}");
  harness_.step();
  EXPECT_EQ(figures()["up"], false);
  test::PtyPair board(link);
  EXPECT_TRUE(test::wait_until([&] {
    harness_.step();
    return figures()["up"] == true;
  }));
  EXPECT_EQ(figures()["lost_lines"], 0);
}

TEST(ExternalAhrsKeys, AreCheckedInOneSentence) {
  const auto refusal = [](const std::string& yaml) {
    return test::refusal([&] {
      test::PluginHarness harness(kStep);
      harness.add("external_ahrs", yaml);
    });
  };
  EXPECT_THAT(refusal("{pty: a, device: b}"), HasSubstr("stands for the line; so does pty"));
  EXPECT_THAT(refusal("{pty: a, model: VN-210}"), HasSubstr("is one of VN-100, VN-200, VN-300"));
  EXPECT_THAT(refusal("{pty: a, solution: perfect}"), HasSubstr("is one of truth, sensors"));
  EXPECT_THAT(refusal("{}"), HasSubstr("device"));
  EXPECT_THAT(refusal("{device: /dev/null}"), HasSubstr("is no terminal"));
}

}  // namespace
}  // namespace cas::sim
