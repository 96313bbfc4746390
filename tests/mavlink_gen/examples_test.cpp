// SPDX-License-Identifier: BSD-3-Clause
// The example programs of docs/develop/mavlink_gen.md, each run with a recorded stream.
#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <filesystem>
#include <string>
#include <vector>

#include "mavlink/common/all.hpp"
#include "mavlink_gen/runtime/codec.hpp"
#include "mavlink_gen/services/tlog.hpp"
#include "tests/support/child_process.hpp"
#include "tests/support/paths.hpp"
#include "tests/support/temporary_folder.hpp"

namespace {

using namespace cas::mav;
namespace common = mavlink::common;

/// Encodes messages of system 1 to a file.
class Recording {
 public:
  template <class Message>
  void add(const Message& message) {
    const auto packet = encode_packet_(message);
    text_.append(packet.begin(), packet.end());
  }
  /// The same, as a record of a telemetry log.
  template <class Message>
  void add_at(std::uint64_t time_us, const Message& message) {
    std::vector<std::uint8_t> record;
    services::append_tlog_record(time_us, encode_packet_(message), record);
    text_.append(record.begin(), record.end());
  }
  /// Output of an example program on it.
  std::string printed_by(const std::string& program, int exit_code = 0) const {
    return printed_by(program, text_, exit_code);
  }
  static std::string printed_by(const std::string& program, const std::string& input,
                                int exit_code = 0) {
    const cas::test::TemporaryFolder folder;
    const std::filesystem::path file = folder.write("input", input);
    FILE* out = ::popen(
        (cas::test::binary_dir() + "/tests/" + program + " < " + file.string()).c_str(), "r");
    if (out == nullptr) return "the program did not start";
    std::string lines;
    std::array<char, 4096> part{};
    while (const std::size_t size = std::fread(part.data(), 1, part.size(), out)) {
      lines.append(part.data(), size);
    }
    EXPECT_EQ(WEXITSTATUS(::pclose(out)), exit_code);
    return lines;
  }

 private:
  Encoder encode_packet_{{.system = 1, .component = 1}};
  std::string text_;
};

TEST(Examples, InspectorPrintsTheMessagesOfItsVisitor) {
  Recording recording;
  recording.add(common::Heartbeat{.type = common::MavType::kQuadrotor,
                                  .base_mode = common::MavModeFlag::kSafetyArmed});
  recording.add(common::HilSensor{});  // has no overload
  recording.add(common::Attitude{.roll = 0.1F, .pitch = -0.2F, .yaw = 1.5F});
  EXPECT_EQ(recording.printed_by("mavlink_inspector"),
            "1/1 HEARTBEAT MAV_TYPE_QUADROTOR armed\n"
            "1/1 ATTITUDE roll 0.10 pitch -0.20 yaw 1.50 rad\n");
}

TEST(Examples, ChangesPrintsTheFieldsThatDiffer) {
  common::Heartbeat heartbeat{.type = common::MavType::kQuadrotor,
                              .custom_mode = 3,
                              .system_status = common::MavState::kStandby};
  Recording recording;
  recording.add(heartbeat);
  recording.add(heartbeat);
  heartbeat.custom_mode = 4;
  heartbeat.system_status = common::MavState::kActive;
  recording.add(heartbeat);
  EXPECT_EQ(recording.printed_by("mavlink_changes"),
            "custom_mode: 3 -> 4\n"
            "system_status: MAV_STATE_STANDBY -> MAV_STATE_ACTIVE\n");
}

TEST(Examples, TlogToCsvPrintsEachMessageOfTheKind) {
  Recording recording;
  recording.add_at(1'764'000'000'250'000,
                   common::Attitude{.time_boot_ms = 5, .roll = 0.1F, .yaw = 1.5F});
  recording.add_at(0xFEFDFE, common::Heartbeat{});  // a time that looks like starts of packets
  recording.add_at(1'764'000'001'500'000, common::Attitude{.time_boot_ms = 6, .roll = -0.25F});
  EXPECT_EQ(recording.printed_by("mavlink_tlog_to_csv ATTITUDE"),
            "time_s,system,component,time_boot_ms,roll,pitch,yaw,rollspeed,pitchspeed,yawspeed\n"
            "1764000000.25,1,1,5,0.100000001,0,1.5,0,0,0\n"
            "1764000001.5,1,1,6,-0.25,0,0,0,0,0\n");
}

TEST(Examples, HelloSendsAHeartbeat) {
  const int socket = ::socket(AF_INET, SOCK_DGRAM, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t length = sizeof address;
  ASSERT_EQ(::bind(socket, reinterpret_cast<sockaddr*>(&address), length), 0);
  ASSERT_EQ(::getsockname(socket, reinterpret_cast<sockaddr*>(&address), &length), 0);
  EXPECT_EQ(Recording().printed_by("mavlink_hello 127.0.0.1 " +
                                   std::to_string(ntohs(address.sin_port)) + " 1"),
            "");
  std::array<std::uint8_t, 512> bytes{};
  const auto size = ::recv(socket, bytes.data(), bytes.size(), MSG_DONTWAIT);  // it is over: sent
  ::close(socket);
  ASSERT_GT(size, 0);
  const auto packet = view_packet(std::span(bytes).first(static_cast<std::size_t>(size)));
  const auto heartbeat = decode<common::Heartbeat>(packet);
  ASSERT_TRUE(heartbeat);
  EXPECT_EQ(heartbeat->type, common::MavType::kQuadrotor);
}

TEST(Examples, SigningSignsAndTellsWhichPacketsAre) {
  Recording recording;
  recording.add(common::Heartbeat{});
  recording.add(common::Attitude{.roll = 0.5F});
  std::string signed_stream = recording.printed_by("mavlink_signing sign 'a phrase'");
  EXPECT_EQ(Recording::printed_by("mavlink_signing check 'a phrase'", signed_stream),
            "1/1 HEARTBEAT accepted\n1/1 ATTITUDE accepted\n");
  EXPECT_EQ(Recording::printed_by("mavlink_signing check 'another'", signed_stream, 1),
            "1/1 HEARTBEAT not signed with this key\n1/1 ATTITUDE not signed with this key\n");
  EXPECT_EQ(recording.printed_by("mavlink_signing check 'a phrase'", 1),
            "1/1 HEARTBEAT not signed\n1/1 ATTITUDE not signed\n");
  signed_stream += signed_stream;
  EXPECT_EQ(Recording::printed_by("mavlink_signing check 'a phrase'", signed_stream, 1),
            "1/1 HEARTBEAT accepted\n1/1 ATTITUDE accepted\n"
            "1/1 HEARTBEAT replayed\n1/1 ATTITUDE replayed\n");
}

TEST(Examples, SigningSaysThatNothingCameAndWhatItLeavesOut) {
  for (const std::string what : {"sign", "check"}) {
    EXPECT_EQ(Recording::printed_by("mavlink_signing " + what + " phrase 2>&1", "no packet", 1),
              "no packet came\n");
  }
  const std::string stream = Recording().printed_by("mavlink_own_dialect 21.5");
  EXPECT_EQ(Recording::printed_by("mavlink_signing check phrase", stream, 1),
            "1/158 HEARTBEAT not signed\n");
  EXPECT_EQ(Recording::printed_by("mavlink_signing check phrase 2>&1 >/dev/null", stream, 1),
            "left out: 1 packets of messages that dialect common does not have\n");
}

TEST(Examples, OwnDialectSendsAndPrintsItsMessage) {
  const std::string stream = Recording().printed_by("mavlink_own_dialect 21.5");
  EXPECT_EQ(Recording::printed_by("mavlink_own_dialect", stream),
            "1/158 LAB_TEMPERATURE 21.50 degC\n");
}

/// The program fcu_emulator on a pseudo-terminal.
class OnALine : public testing::Test {
 protected:
  void SetUp() override { ASSERT_TRUE(emulator_.wait_ready()) << emulator_.output(); }

  cas::test::TemporaryFolder folder_;
  std::string line_ = (folder_ / "fcu0").string();
  cas::test::ChildProcess emulator_{
      {cas::test::binary_dir() + "/bin/fcu_emulator",
       folder_
           .write("fcu.yaml", "schema: 1\nvehicle: " + cas::test::source_dir() +
                                  "/config/vehicles/iris_paper.yaml\n")
           .string(),
       "--link", line_}};
};

TEST_F(OnALine, ParamBackupPrintsAllThereAre) {
  const std::string printed = Recording().printed_by("mavlink_param_backup " + line_);
  EXPECT_NE(printed.find("\nMC_ROLL_P  "), std::string::npos) << printed;
  EXPECT_NE(printed.find("\nSYS_AUTOSTART  "), std::string::npos) << printed;
  EXPECT_GT(std::ranges::count(printed, '\n'), 50);
}

TEST_F(OnALine, MissionUploadPrintsWhatTheVehicleHas) {
  const std::string wanted =
      "0: 47.3977420 8.5455940 10.0\n1: 47.3978420 8.5455940 12.5\n"
      "2: 47.3977420 8.5456940 10.0\n";
  EXPECT_EQ(Recording::printed_by("mavlink_mission_upload " + line_,
                                  "47.3977420 8.5455940 10\n47.3978420 8.5455940 12.5\n"
                                  "47.3977420 8.5456940 10\n"),
            wanted);
}

TEST_F(OnALine, MissionUploadSendsNothingOfWhatAreNoWayPoints) {
  const std::string program = "mavlink_mission_upload " + line_;
  const std::string good = "47.3977420 8.5455940 10\n";
  for (const std::string bad : {"", "hello\n", "47.4,8.5,10\n", "47.4 8.5\n", "47.4 8.5 10 x\n",
                                "91 8.5 10\n", "47.4 1e300 10\n", "47.4 8.5 1e300\n"}) {
    EXPECT_EQ(Recording::printed_by(program + " 2>&1", bad.empty() ? bad : good + bad, 2),
              "each line must be LATITUDE LONGITUDE HEIGHT, in degrees and m; nothing was sent\n")
        << bad;
  }
}

TEST_F(OnALine, MissionUploadSaysWhatTheVehicleDoesNotTake) {
  std::string too_many;
  for (int i = 0; i < 501; ++i) too_many += "47.3977420 8.5455940 10\n";
  EXPECT_EQ(Recording::printed_by("mavlink_mission_upload " + line_ + " 2>&1", too_many, 1),
            "the vehicle asked for 0 of 501 items: no space\n");
}

}  // namespace
