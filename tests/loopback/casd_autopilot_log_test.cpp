// SPDX-License-Identifier: BSD-3-Clause
// The real casd takes the logs of scripted autopilots over UDP.
#include <gmock/gmock.h>

#include <algorithm>
#include <csignal>
#include <deque>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "tests/hils/ulog/ulog_bytes.hpp"
#include "tests/loopback/running_casd.hpp"
#include "tests/loopback/udp_autopilot.hpp"
#include "tests/support/file_size_limit.hpp"
#include "tests/support/temporary_folder.hpp"
#include "tests/support/wait_until.hpp"

namespace cas::test {
namespace {

using testing::HasSubstr;
using testing::Not;

namespace fs = std::filesystem;
using namespace mavlink::common;
using mav::services::RemoteLogBlockStatus;

std::string beginning() {
  return UlogBytes().format("level:uint64_t timestamp;").subscribe(3, "level").bytes();
}

std::string message(std::uint64_t time_us) {
  return UlogBytes().data(3, time_us, "").bytes().substr(16);
}

class CasdAutopilotLog : public testing::Test {
 protected:
  /// @param keep  keys of log.keep
  void start(const std::string& keep, const std::string& link_keys = "",
             const std::string& autopilot = "") {
    start_with("{folder: " + (folder / "rec").string() + ", keep: {" + keep + "}, autopilot: {" +
                   autopilot + "}}",
               link_keys);
  }
  void start_with(const std::string& log, const std::string& link_keys = "") {
    const std::string topology = folder.write(
        "topology.yaml",
        "schema: 1\ncommand_port: {port: 0, loopback_without_token: true}\nlog: " + log +
            "\n"
            "links:\n  - {name: net, type: udp_server, local: \"127.0.0.1:0\"" +
            link_keys + "}\n");
    casd.emplace(std::vector<std::string>{kCasdProgram, topology});
    port = casd->port("net");
  }
  std::vector<fs::path> files() const {
    std::vector<fs::path> all;
    if (!fs::exists(folder / "rec")) return all;
    for (const auto& entry : fs::directory_iterator(folder / "rec")) all.push_back(entry.path());
    return all;
  }
  std::string casctl(const std::vector<std::string>& arguments) const {
    return casd->casctl(arguments).output;
  }
  void end() {
    casd->signal(SIGTERM);
    ASSERT_EQ(casd->wait_exit(), 0) << casd->output();
  }

  /// The autopilot speaks to casd over link `net`.
  UdpAutopilot& connect(UdpAutopilot& autopilot) const {
    autopilot.socket.set_remote(port);
    return autopilot;
  }
  /// Until casd has the beginning of the log of `px4`.
  void begin_log() {
    ASSERT_TRUE(speaks_until(connect(px4), [&] { return px4.starts == 1; }));
    px4.piece<LoggingDataAcked>(0, beginning());
  }
  void log_begins() {
    begin_log();
    ASSERT_TRUE(speaks_until(px4, [&] { return px4.acks.size() == 1; }));
  }
  /// Whether the one file has so many bytes.
  bool one_file_of(std::size_t bytes) const {
    return files().size() == 1 && fs::file_size(files()[0]) == bytes;
  }
  /// Sends one message after the other.
  std::function<void()> further_messages() {
    return [this] {
      ++number;
      px4.piece(number, message(number));
    };
  }

  TemporaryFolder folder;
  std::optional<RunningCasd> casd;
  std::uint16_t port = 0;
  UdpAutopilot px4{MavAutopilot::kPx4};
  std::uint16_t number = 0;  ///< of the newest message
};

TEST_F(CasdAutopilotLog, Px4sLogIsAFileWithADropoutWhereAPieceIsLost) {
  start("free_space_min_mib: 0");
  connect(px4);
  px4.answers = false;
  ASSERT_TRUE(speaks_until(px4, [&] { return px4.starts >= 2; })) << "repeated until acknowledged";
  px4.answers = true;
  px4.piece<LoggingDataAcked>(0, beginning());
  ASSERT_TRUE(speaks_until(px4, [&] { return px4.acks == std::vector<std::uint16_t>{0}; }));
  // Another peer in the vehicle's name.
  UdpAutopilot liar(MavAutopilot::kPx4);
  connect(liar);
  liar.piece(1, message(666));
  liar.piece(2, message(667));
  const std::string cut = message(1) + message(2).substr(0, 5);
  px4.piece(1, cut);
  px4.piece<LoggingDataAcked>(3, "xxx" + message(4), 3);
  ASSERT_TRUE(speaks_until(px4, [&] { return px4.acks.size() == 2; }));
  end();
  px4.pump();
  EXPECT_GE(px4.stops, 1);
  ASSERT_EQ(files().size(), 1U);
  EXPECT_THAT(files()[0].filename().string(), HasSubstr("Z-v1.ulg")) << files()[0];
  const std::string file = TemporaryFolder::read(files()[0]);
  const std::string before = beginning() + message(1);
  ASSERT_EQ(file.size(), before.size() + 5 + message(4).size());
  EXPECT_EQ(file.substr(0, before.size()), before);
  EXPECT_EQ(file.substr(before.size(), 3), std::string("\x02\0O", 3)) << "a dropout";
  EXPECT_EQ(file.substr(before.size() + 5), message(4));
}

TEST_F(CasdAutopilotLog, ArduPilotsBlocksAreInTheirPlaces) {
  start("free_space_min_mib: 0");
  UdpAutopilot apm(MavAutopilot::kArdupilotmega);
  connect(apm);
  ASSERT_TRUE(speaks_until(apm, [&] {
    return apm.was_told(RemoteLogBlockStatus::kStop, 1) &&
           apm.was_told(RemoteLogBlockStatus::kStart, 1);
  }));
  apm.block(0, 'a');
  apm.block(2, 'c');
  ASSERT_TRUE(speaks_until(apm, [&] { return apm.was_told(1, 0); })) << "asked for again";
  apm.block(1, 'b');
  ASSERT_TRUE(speaks_until(
      apm, [&] { return apm.was_told(0, 1) && apm.was_told(1, 1) && apm.was_told(2, 1); }));
  apm.statuses.clear();
  end();
  apm.pump();
  EXPECT_TRUE(apm.was_told(RemoteLogBlockStatus::kStop, 1));
  ASSERT_EQ(files().size(), 1U);
  EXPECT_THAT(files()[0].filename().string(), HasSubstr("Z-v1.bin")) << files()[0];
  EXPECT_EQ(TemporaryFolder::read(files()[0]),
            std::string(200, 'a') + std::string(200, 'b') + std::string(200, 'c'));
}

TEST_F(CasdAutopilotLog, RunsFromArmingToDisarming) {
  start("free_space_min_mib: 0", "", "while_armed: true");
  connect(px4);
  ASSERT_TRUE(speaks_until(px4, [&] { return px4.requests >= 2; })) << "it is known";
  EXPECT_EQ(px4.starts, 0);
  px4.base_mode = MavModeFlag::kCustomModeEnabled | MavModeFlag::kSafetyArmed;
  ASSERT_TRUE(speaks_until(px4, [&] { return px4.starts == 1; }));
  px4.piece<LoggingDataAcked>(0, beginning());
  ASSERT_TRUE(speaks_until(px4, [&] { return px4.acks.size() == 1; }));
  px4.base_mode = MavModeFlag::kCustomModeEnabled;
  ASSERT_TRUE(speaks_until(px4, [&] { return px4.stops == 1; }));
  EXPECT_TRUE(wait_until([&] { return one_file_of(beginning().size()); }));
}

TEST_F(CasdAutopilotLog, OfOtherVehiclesThanThoseOfTheTopologyAreNotTaken) {
  start("free_space_min_mib: 0", "", "systems: [2]");
  UdpAutopilot other(MavAutopilot::kPx4);
  connect(other);
  UdpAutopilot wanted(MavAutopilot::kPx4);
  connect(wanted);
  wanted.encoder = mav::Encoder{{2, 1}};
  ASSERT_TRUE(speaks_until(
      wanted, [&] { return wanted.starts > 0 && other.requests > 0; },
      [&] {
        other.beat();
        other.pump();
      }));
  EXPECT_EQ(other.starts, 0);
  end();
}

TEST_F(CasdAutopilotLog, InventedVehiclesOfALinkKeepNoneOfAnotherLinkOut) {
  start("free_space_min_mib: 0", "}\n  - {name: line, type: udp_server, local: \"127.0.0.1:0\"");
  std::deque<UdpAutopilot> flood;
  for (std::uint8_t system = 101; system <= 118; ++system) {
    flood.emplace_back(MavAutopilot::kPx4).encoder = mav::Encoder({system, 1});
    flood.back().socket.set_remote(port);
  }
  const auto asked = [&] {
    return std::count_if(flood.begin(), flood.end(),
                         [](const auto& px4) { return px4.starts > 0; });
  };
  int turn = 0;
  const auto speak = [&] {
    const bool beats = turn++ % 50 == 0;
    for (UdpAutopilot& px4 : flood) {
      if (beats) px4.beat();
      px4.pump();
    }
  };
  ASSERT_TRUE(wait_until([&] {
    speak();
    return asked() == 16 && casd->output().find("is not asked for its log") != std::string::npos;
  })) << asked();
  px4.socket.set_remote(casd->port("line"));
  EXPECT_TRUE(speaks_until(
      px4, [&] { return px4.starts > 0; }, speak));
  px4.piece<LoggingDataAcked>(0, beginning());
  EXPECT_TRUE(speaks_until(
      px4, [&] { return !px4.acks.empty(); }, speak));
  EXPECT_EQ(px4.stops, 0);
}

TEST_F(CasdAutopilotLog, SaysAtTheStartThatAFolderTakesNoFiles) {
  folder.write("rec", "a file, not a folder");
  start_with("{folder: " + (folder / "rec").string() + ", while_armed: true, autopilot: {}}");
  const auto says = [&](const char* words) { return casd->prints(words); };
  EXPECT_TRUE(says("logs of autopilots in ")) << casd->output();
  EXPECT_TRUE(says("pause: Not a directory")) << casd->output();
  EXPECT_TRUE(says("cannot record in ")) << casd->output();
  const std::string where = (folder / "rec").string() + ": Not a directory";
  EXPECT_TRUE(wait_until([&] {
    return casctl({"log", "status"}).find("CANNOT RECORD in " + where) != std::string::npos;
  }));
  EXPECT_THAT(casctl({"status"}), HasSubstr("CANNOT RECORD in " + where));
  EXPECT_THAT(casctl({"doctor", "--seconds", "0.1"}), HasSubstr("casd cannot record in " + where));
  fs::remove(folder / "rec");
  EXPECT_TRUE(wait_until([&] {
    return casctl({"log", "status"}).find("CANNOT RECORD") == std::string::npos;
  }));
  EXPECT_TRUE(says("can record in ")) << casd->output();
  end();
}

TEST_F(CasdAutopilotLog, PausesAtALimitAndSaysSo) {
  start("free_space_min_mib: 1e8");  // more than any disk has
  begin_log();
  EXPECT_TRUE(speaks_until(px4, [&] { return px4.stops >= 1; })) << "nobody takes it";
  EXPECT_THAT(casd->output(), HasSubstr("pause: less than 100000000 MiB would stay free"));
  EXPECT_TRUE(wait_until([&] { return files().empty(); }));
  for (const char* verb : {"status", "doctor"}) {
    std::vector<std::string> arguments{verb};
    if (arguments[0] == "doctor") arguments.insert(arguments.end(), {"--seconds", "0.1"});
    const std::string said = casctl(arguments);
    EXPECT_THAT(said, HasSubstr("less than 100000000 MiB would stay free"));
  }
}

TEST_F(CasdAutopilotLog, StatusTellsOfEachVehiclesLogAndTheOldestFilesGo) {
  folder.write("rec/2026-01-01T00-00-00Z-v1.ulg", "x");
  folder.write("rec/2026-01-02T00-00-00Z-v7.bin", "x");
  folder.write("rec/mine.ulg", "x");
  start("free_space_min_mib: 0, max_files: 2");
  EXPECT_THAT(casctl({"status"}), HasSubstr("/rec; no vehicle yet"));
  connect(px4);
  px4.answers = false;
  ASSERT_TRUE(speaks_until(px4, [&] { return px4.starts >= 1; }));
  EXPECT_THAT(casctl({"status"}), HasSubstr("vehicle 1: asked, no data yet"));
  px4.answers = true;
  px4.piece<LoggingDataAcked>(0, beginning());
  ASSERT_TRUE(speaks_until(px4, [&] { return px4.acks.size() == 1; }));
  const std::string bytes = "-v1.ulg, " + std::to_string(beginning().size()) + " bytes";
  std::string said;
  EXPECT_TRUE(speaks_until(px4, [&] {
    said = casctl({"status"});
    return said.find(bytes) != std::string::npos;
  })) << said;
  EXPECT_TRUE(fs::exists(folder / "rec/mine.ulg"));
  EXPECT_FALSE(fs::exists(folder / "rec/2026-01-01T00-00-00Z-v1.ulg"));
  EXPECT_TRUE(fs::exists(folder / "rec/2026-01-02T00-00-00Z-v7.bin"));
  end();
}

TEST_F(CasdAutopilotLog, DoctorTellsOfAnArmedAutopilotThatSendsNone) {
  start("free_space_min_mib: 0");
  connect(px4);
  px4.base_mode = MavModeFlag::kCustomModeEnabled | MavModeFlag::kSafetyArmed;
  std::string said;
  EXPECT_TRUE(speaks_until(px4, [&] {
    said = casctl({"doctor", "--seconds", "0.1"});
    return said.find("vehicle 1 is armed, was asked for its log and sends none") !=
           std::string::npos;
  })) << said;
}

TEST_F(CasdAutopilotLog, BeginsAnotherFileForOneThatWasDeleted) {
  start("free_space_min_mib: 0");
  begin_log();
  ASSERT_TRUE(speaks_until(px4, [&] { return one_file_of(beginning().size()); }));
  const std::string deleted = files()[0].filename().string();
  fs::remove(files()[0]);
  ASSERT_TRUE(speaks_until(
      px4,
      [&] {
        return casd->output().find(deleted + " was deleted while it was written") !=
               std::string::npos;
      },
      further_messages()))
      << casd->output();
  ASSERT_TRUE(speaks_until(px4, [&] { return px4.starts >= 2; })) << casd->output();
  px4.piece<LoggingDataAcked>(0, beginning());
  EXPECT_TRUE(speaks_until(px4, [&] { return one_file_of(beginning().size()); })) << casd->output();
}

TEST_F(CasdAutopilotLog, PausesBeforeAllLogsTakeMoreThanTheyMay) {
  constexpr std::uintmax_t kMost = 1024 * 1024;
  folder.write("rec/old.ulg", std::string(kMost - 500, 'x'));
  start("free_space_min_mib: 0, max_mib: 1");
  const auto taken = [&] {
    std::uintmax_t sum = 0;
    for (const fs::path& file : files()) sum += fs::file_size(file);
    return sum;
  };
  log_begins();
  EXPECT_TRUE(speaks_until(
      px4, [&] { return px4.stops >= 1; }, further_messages()))
      << "nobody takes it";
  EXPECT_THAT(casd->output(), HasSubstr("pause: the recordings have the 1 MiB that they may take"));
  ASSERT_TRUE(wait_until([&] { return files().size() == 2; }));
  EXPECT_LE(taken(), kMost);
  EXPECT_GT(taken(), kMost - 500 + beginning().size()) << "it was used first";

  for (const fs::path& file : files()) fs::remove(file);
  EXPECT_TRUE(speaks_until(px4, [&] { return px4.starts >= 2; })) << casd->output();
}

TEST_F(CasdAutopilotLog, OldLogsMakeRoomForNewOnesWhereTheTopologySaysSo) {
  const fs::path old =
      folder.write("rec/2026-01-01T00-00-00Z-v1.ulg", std::string(1024 * 1024 - 500, 'x'));
  const fs::path mine = folder.write("rec/mine.ulg", "x");
  start("free_space_min_mib: 0, max_mib: 1");
  log_begins();
  EXPECT_TRUE(speaks_until(
      px4, [&] { return !fs::exists(old); }, further_messages()));
  EXPECT_EQ(px4.stops, 0);
  EXPECT_TRUE(fs::exists(mine));
  EXPECT_THAT(casd->output(), Not(HasSubstr("pause:")));
}

TEST_F(CasdAutopilotLog, GoesOnInAnotherFileWhenFilesMayGrowAgain) {
  start("free_space_min_mib: 0");
  connect(px4);
  ASSERT_TRUE(speaks_until(px4, [&] { return px4.starts == 1; }));
  {
    const FileSizeLimit full(0, casd->pid());
    px4.piece<LoggingDataAcked>(0, beginning());
    ASSERT_TRUE(speaks_until(px4, [&] { return px4.stops >= 1; })) << casd->output();
  }
  ASSERT_TRUE(speaks_until(px4, [&] { return px4.starts >= 2; })) << casd->output();
  const std::string other = UlogBytes(2'000'000).format("level:uint64_t timestamp;").bytes();
  ASSERT_TRUE(speaks_until(
      px4, [&] { return one_file_of(other.size()); },
      [&] { px4.piece<LoggingDataAcked>(0, other); }));
  EXPECT_EQ(TemporaryFolder::read(files()[0]), other);
}

}  // namespace
}  // namespace cas::test
