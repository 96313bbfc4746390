// SPDX-License-Identifier: BSD-3-Clause
// `hils timing` on the pseudo-terminal of fcu_emulator, whose byte clock is the truth.
#include <fcntl.h>
#include <gmock/gmock.h>
#include <sys/file.h>

#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "base/os/descriptor.hpp"
#include "mavlink/common/heartbeat.hpp"
#include "mavlink_gen/runtime/encode.hpp"
#include "tests/support/ended_with.hpp"
#include "tests/support/paths.hpp"
#include "tests/support/pty_pair.hpp"
#include "tests/support/temporary_folder.hpp"

namespace cas::test {
namespace {

using nlohmann::json;
using testing::HasSubstr;

#ifdef CAS_TIMING_REALTIME
constexpr bool kQuietMachine = true;
#else
constexpr bool kQuietMachine = false;
#endif

/// Longest that a measurement takes on a busy machine.
constexpr auto kMeasurement = std::chrono::seconds(150);

class HilsTiming : public testing::Test {
 protected:
  void start_emulator(const std::string& line) {
    const auto config =
        folder_.write("fcu.yaml", "schema: 1\nvehicle: " + source_dir() +
                                      "/config/vehicles/iris_paper.yaml\nline: " + line + "\n");
    emulator_ = std::make_unique<ChildProcess>(std::vector<std::string>{
        binary_dir() + "/bin/fcu_emulator", config.string(), "--link", device()});
    ASSERT_TRUE(emulator_->wait_ready()) << emulator_->output();
  }
  std::unique_ptr<ChildProcess> start(std::vector<std::string> arguments) const {
    const std::vector<std::string> begin{"/usr/bin/env", "CAS_BOARDS=" + boards_,
                                         binary_dir() + "/bin/hils", "timing"};
    arguments.insert(arguments.begin(), begin.begin(), begin.end());
    return std::make_unique<ChildProcess>(arguments);
  }
  Ended hils(std::vector<std::string> arguments) const {
    return start(std::move(arguments))->end(kMeasurement);
  }
  std::string device() const { return (folder_ / "fcu").string(); }
  json figures() const { return json::parse(TemporaryFolder::read(folder_ / "timing.json")); }

  TemporaryFolder folder_;
  std::string boards_;
  std::unique_ptr<ChildProcess> emulator_;
};

struct BaudCase {
  const char* name;
  int baud;
  int code;
};

class HilsTimingAt : public HilsTiming, public testing::WithParamInterface<BaudCase> {};

TEST_P(HilsTimingAt, TellsWhatTheByteClockLetsThrough) {
  const BaudCase& test = GetParam();
  start_emulator("{preset: baud_921600, baud: " + std::to_string(test.baud) + "}");
  const Ended answer = hils({"--fcu", device(), "--baud", std::to_string(test.baud), "--json",
                             (folder_ / "timing.json").string()});
  const json said = figures();
  // A busy machine leaves the line idle now and then, and marks the moments late: the byte clock
  // bounds the rate, within the blur of five pieces of 0.3 s.
  const double bytes_s = test.baud / 10.0;
  const double low = kQuietMachine ? 0.95 : 0.4;
  const double high = kQuietMachine ? 1.05 : 1.25;
  for (const char* way : {"to_bytes_s", "from_bytes_s"}) {
    EXPECT_GT(said.at(way).get<double>(), low * bytes_s) << way;
    EXPECT_LT(said.at(way).get<double>(), high * bytes_s) << way;
  }
  // 24 bytes of PING there and 26 back. No machine makes the line faster; a quiet one needs 0.2 ms
  // for two wake-ups of each program.
  const double least_ms = 1e3 * 50 / bytes_s;
  EXPECT_GE(said.at("ping").at("least_ms").get<double>(), 0.99 * least_ms);
  EXPECT_LT(said.at("ping").at("least_ms").get<double>(),
            kQuietMachine ? 1.05 * least_ms + 0.2 : least_ms + 50);
  EXPECT_TRUE(said.at("in_hil"));
  if (test.code != 0 || kQuietMachine) {
    EXPECT_EQ(answer.code, test.code) << answer.output;
  }
  EXPECT_THAT(answer.output, HasSubstr(said.at("verdict").at("sentence").get<std::string>()));
  EXPECT_EQ(said.at("pseudo_terminal"), true);
  EXPECT_THAT(answer.output, HasSubstr("a pseudo-terminal has no baud rate"));
  if (kQuietMachine && test.baud == 115'200) {
    EXPECT_EQ(said.at("verdict").at("fitting_sensor_hz"), 125) << answer.output;
  }
}

INSTANTIATE_TEST_SUITE_P(Bauds, HilsTimingAt,
                         testing::Values(BaudCase{"At57600", 57'600, 1},
                                         BaudCase{"At115200", 115'200, 1},
                                         BaudCase{"At921600", 921'600, 0}),
                         [](const auto& test) { return test.param.name; });

#ifdef CAS_TIMING_REALTIME

TEST_F(HilsTiming, SeesTheFramesOfTheUsbPreset) {
  start_emulator("{preset: usb}");
  const Ended answer = hils({"--fcu", device(), "--json", (folder_ / "timing.json").string()});
  EXPECT_EQ(answer.code, 0) << answer.output;
  EXPECT_EQ(figures().at("frame_us"), 1000) << answer.output;
}

#else

TEST_F(HilsTiming, SaysThatAPortIsNotThere) {
  EXPECT_THAT(hils({"--fcu", device()}),
              EndedWith(4, testing::Eq("hils: " + device() + ": there is no such port\n")));
}

TEST_F(HilsTiming, TakesNoPortFromAnotherProgram) {
  const PtyPair line(device());
  const base::Descriptor other(::open(device().c_str(), O_RDWR | O_NOCTTY | O_CLOEXEC));
  ASSERT_EQ(::flock(other.get(), LOCK_EX | LOCK_NB), 0);
  EXPECT_THAT(hils({"--fcu", device()}), EndedWith(7, device() + ": in use"));
}

TEST_F(HilsTiming, TakesTheLockOfABoard) {
  boards_ =
      folder_
          .write("boards.yaml", "schema: 1\nlock_folder: locks\nboards: {a: {device: " + device() +
                                    ", baud: 921600}}\n")
          .string();
  std::filesystem::create_directory(folder_ / "locks");
  const ChildProcess holder({"/usr/bin/env", "CAS_BOARDS=" + boards_, binary_dir() + "/bin/hils",
                             "board", "lock", "a", "--for", "a test", "--", "sh", "-c",
                             "touch " + (folder_ / "held").string() + "; exec sleep 600"});
  // A query of a free board takes its lock for a moment, and the holder would find it taken.
  ASSERT_TRUE(wait_until([&] { return std::filesystem::exists(folder_ / "held"); }));
  EXPECT_THAT(hils({"--fcu", "a"}), EndedWith(7, "a test"));
}

TEST_F(HilsTiming, LoadsNoLineOfAnArmedVehicle) {
  PtyPair line(device());
  mavlink::common::Heartbeat armed;
  armed.autopilot = mavlink::common::MavAutopilot::kPx4;
  armed.base_mode = mavlink::common::MavModeFlag::kSafetyArmed;
  mav::Encoder encode({1, 1});
  const auto child = start({"--fcu", device()});
  std::optional<int> code;
  EXPECT_TRUE(wait_until([&] {
    line.write(encode(armed));
    code = child->wait_exit(std::chrono::milliseconds(100));
    return code.has_value();
  }));
  EXPECT_EQ(code, 6);
  EXPECT_EQ(child->output(),
            "hils: " + device() + ": a vehicle there is armed, and its line is not loaded\n");
}

TEST_F(HilsTiming, HasNoVerdictOnASilentLine) {
  const PtyPair line(device());
  EXPECT_THAT(hils({"--fcu", device(), "--baud", "57600"}),
              EndedWith(3, "no HEARTBEAT came from " + device() + " at 57600 baud"));
}

TEST_F(HilsTiming, SaysThatALineWentAway) {
  PtyPair line(device());
  PacketStream heard;
  const auto child = start({"--fcu", device()});
  EXPECT_TRUE(wait_until([&] { return line.read(heard) > 0; }));
  line.hang_up();
  EXPECT_EQ(child->wait_exit(), 4);
  EXPECT_EQ(child->output(), "hils: " + device() + " went away during the measurement\n");
}

#endif

}  // namespace
}  // namespace cas::test
