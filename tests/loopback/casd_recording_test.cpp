// SPDX-License-Identifier: BSD-3-Clause
// Recordings of the real casd: their folders, and the effect of a full disk.
#include <gmock/gmock.h>
#include <unistd.h>

#include <chrono>
#include <filesystem>
#include <fstream>
#include <functional>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>

#include "casd/tlog/tlog_files.hpp"
#include "casd/tlog/tlog_name.hpp"
#include "tests/loopback/casd_fixture.hpp"
#include "tests/loopback/running_casd.hpp"
#include "tests/support/file_size_limit.hpp"
#include "tests/support/paths.hpp"

namespace cas::test {
namespace {

using testing::HasSubstr;
using testing::Not;

namespace fs = std::filesystem;
using nlohmann::json;

class CasdRecording : public testing::Test {
 protected:
  /// @param log  the keys of `log` beside its folder
  /// @param prefix  words before the program and its file
  void start(const std::string& log, std::vector<std::string> prefix = {}) {
    recordings = fixture.folder / "rec";
    fs::create_directory(recordings);
    const std::string topology = fixture.folder.write(
        "topology.yaml",
        fixture.expand(
            "command_port: {port: 0, loopback_without_token: true}\ncommanding: {heartbeat_hz: 0}\n"
            "log: {folder: $DIR/rec, " +
            log + "}\n" + kHilTopology));
    if (prefix.empty()) {
      prefix = {kCasdProgram, topology};
    } else {
      prefix.back() += " && exec " + kCasdProgram + " " + topology;
    }
    casd.emplace(prefix);
    fixture.sim.set_remote(casd->port("sim"));
  }
  json call(const std::string& method, const json& params = json::object()) {
    return casd->call(method, params);
  }
  std::string casctl(const std::vector<std::string>& arguments) const {
    return casd->casctl(arguments).output;
  }
  /// One more packet through casd.
  void send() {
    fixture.sim.send(fixture.from_sim(hil_sensor(++sent)));
    fixture.collect();
  }
  /// Sends until it holds. A look may take a while: casd slows down a client that asks without a
  /// pause.
  bool send_until(const std::function<bool()>& condition) {
    constexpr int kPacketsALook = 20;
    return wait_until([&] {
      for (int i = 0; i < kPacketsALook; ++i) send();
      return condition();
    });
  }
  bool is_paused() { return call("log.status").contains("paused"); }
  /// Packets in all .tlog files of a folder, none of them torn.
  static std::size_t packets_in(const fs::path& folder) {
    std::size_t count = 0;
    for (const auto& entry : fs::directory_iterator(folder)) {
      if (entry.path().extension() != ".tlog") continue;
      casd::TlogReader reader;
      EXPECT_TRUE(reader.open(entry.path())) << entry.path();
      while (reader.next()) ++count;
      EXPECT_EQ(reader.skipped_bytes(), 0U) << entry.path();
    }
    return count;
  }
  static std::ptrdiff_t files_in(const fs::path& folder) {
    return std::distance(fs::directory_iterator(folder), fs::directory_iterator{});
  }
  /// After the end of a recording that began with casd: each packet that casd received is in a file
  /// or counted as missing, and the figures are those of the files.
  void expect_true_figures(const fs::path& folder) {
    ASSERT_TRUE(fixture.collect_until([&] { return fixture.at_fcu.count(kHilSensor) == sent; }));
    const json status = call("log.stop");
    EXPECT_EQ(status.at("recorded").get<std::uint64_t>(), packets_in(folder));
    EXPECT_EQ(
        status.at("recorded").get<std::uint64_t>() + status.at("left_out").get<std::uint64_t>(),
        sent);
  }

  CasdFixture fixture;
  fs::path recordings;
  std::optional<RunningCasd> casd;
  std::uint64_t sent = 0;
};

TEST_F(CasdRecording, StaysInItsFolderWhateverAClientAsksFor) {
  start("keep: {free_space_min_mib: 0}");
  const auto around = files_in(fixture.folder.path());
  for (const char* name : {"/tmp/x.tlog", "../x", "a/../../x", "a/b", ".x", "..", "a\u0001b"}) {
    const std::string said = casd->refusal("log.start", {{"file", name}});
    EXPECT_THAT(said, HasSubstr("the folder for recordings")) << name << ": ";
  }
  EXPECT_EQ(files_in(recordings), 0);
  EXPECT_EQ(files_in(fixture.folder.path()), around);

  const std::string first = call("log.start", {{"file", "x.tlog"}}).at("file");
  const std::string second = call("log.start", {{"file", "x.tlog"}}).at("file");
  const std::string nameless = call("log.start").at("file");
  for (const std::string& file : {first, second, nameless}) {
    EXPECT_EQ(fs::path(file).parent_path(), recordings);
    EXPECT_EQ(fs::path(file).extension(), ".tlog");
  }
  EXPECT_THAT(first, HasSubstr("Z-x."));
  EXPECT_NE(first, second);
  EXPECT_EQ(files_in(recordings), 3);
}

TEST_F(CasdRecording, FollowsNoSymlinkAndEmptiesNoFile) {
  start("keep: {free_space_min_mib: 0}");
  const fs::path victim = fixture.folder.write("victim", "theirs");
  const fs::path nothing = fixture.folder / "nothing";
  // A user with write access to the folder can predict the names.
  const auto now = std::chrono::duration_cast<std::chrono::seconds>(
      std::chrono::system_clock::now().time_since_epoch());
  for (int i = 0; i < 60; ++i) {
    const std::string dated = casd::dated_tlog_name(now + std::chrono::seconds(i), "x");
    fs::create_symlink(nothing, recordings / casd::tlog_file_name(dated, 0));
    fs::create_symlink(victim, recordings / casd::tlog_file_name(dated, 1));
  }
  const fs::path file = call("log.start", {{"file", "x"}}).at("file").get<std::string>();
  ASSERT_TRUE(send_until([&] { return call("log.status").at("recorded") > 0; }));
  call("log.stop");
  EXPECT_EQ(file.stem().extension(), ".2") << file;
  EXPECT_TRUE(fs::is_regular_file(fs::symlink_status(file)));
  EXPECT_FALSE(fs::exists(nothing));
  EXPECT_EQ(TemporaryFolder::read(victim), "theirs");
}

TEST_F(CasdRecording, FromTheStartIsNamedByItsDateOrWrittenAnew) {
  start("tlog: flight, keep: {free_space_min_mib: 0}");
  const std::string dated = call("log.status").at("file");
  EXPECT_THAT(dated, HasSubstr("Z-flight.tlog"));

  const fs::path victim = fixture.folder.write("victim", "theirs");
  fs::create_symlink(victim, recordings / "flight.tlog");
  const CasdFixture other;
  const std::string log =
      "log: {folder: " + recordings.string() + ", tlog: flight, overwrite: true}\n";
  const std::string topology = other.folder.write(
      "topology.yaml",
      other.expand("command_port: {port: 0, loopback_without_token: true}\n" + log + kHilTopology));
  ChildProcess second({binary_dir() + "/bin/casd", topology});
  ASSERT_TRUE(second.wait_ready()) << second.output();
  EXPECT_TRUE(fs::is_regular_file(fs::symlink_status(recordings / "flight.tlog")));
  EXPECT_EQ(TemporaryFolder::read(victim), "theirs");
}

TEST_F(CasdRecording, OfOldOnesTheNewestStayAndNothingElseGoes) {
  const fs::path victim = fixture.folder.write("victim", "theirs");
  for (const char* name : {"2026-11-01T00-00-00Z-a.tlog", "2026-11-02T00-00-00Z-a.tlog",
                           "2026-11-03T00-00-00Z-a.tlog", "mine.tlog"}) {
    fixture.folder.write(std::string("rec/") + name, "old");
  }
  fs::create_symlink(victim, fixture.folder / "rec/2026-10-01T00-00-00Z-a.tlog");
  start("tlog: flight, keep: {free_space_min_mib: 0, max_files: 2}");
  EXPECT_EQ(files_in(recordings), 4) << "the link, mine.tlog, the newest old one, the new one";
  EXPECT_TRUE(fs::exists(recordings / "2026-11-03T00-00-00Z-a.tlog"));
  EXPECT_THAT(casd->output(), HasSubstr("2026-11-01T00-00-00Z-a.tlog, 2 files may stay"));

  const fs::path first = call("log.status").at("file").get<std::string>();
  call("log.start", {{"file", "x"}});
  const fs::path second = call("log.start", {{"file", "y"}}).at("file").get<std::string>();
  EXPECT_EQ(files_in(recordings), 4);
  EXPECT_FALSE(fs::exists(first));
  EXPECT_TRUE(fs::exists(second));
  EXPECT_TRUE(fs::exists(recordings / "mine.tlog"));
  EXPECT_EQ(TemporaryFolder::read(victim), "theirs");
}

TEST_F(CasdRecording, DeletesOldOnesForANewOneWhereTheTopologySaysSo) {
  fixture.folder.write("rec/2026-11-01T00-00-00Z-a.tlog", std::string(1024 * 1024, 'x'));
  fixture.folder.write("rec/mine.tlog", "old");
  start("tlog: flight, keep: {free_space_min_mib: 0, max_mib: 1}");
  ASSERT_TRUE(send_until([&] { return call("log.status").at("recorded") > 5; }));
  EXPECT_FALSE(fs::exists(recordings / "2026-11-01T00-00-00Z-a.tlog"));
  EXPECT_TRUE(fs::exists(recordings / "mine.tlog"));
  EXPECT_THAT(casd->output(), HasSubstr("2026-11-01T00-00-00Z-a.tlog to make room"));
}

TEST_F(CasdRecording, PausesWhileFilesMayNotGrowAndGoesOnByItself) {
  start("tlog: flight, keep: {free_space_min_mib: 0}");
  ASSERT_TRUE(send_until([&] { return call("log.status").at("recorded") > 5; }));
  {
    const FileSizeLimit full(0, casd->pid());
    ASSERT_TRUE(send_until([&] { return is_paused(); }));
    const json status = call("casd.status").at("recording");
    EXPECT_EQ(status.at("active"), true);
    EXPECT_EQ(status.at("paused"), "File too large");
    EXPECT_GT(status.at("left_out").get<int>(), 0);
    const std::string said = casctl({"status"});
    EXPECT_THAT(said, HasSubstr("recording PAUSED for"));
    EXPECT_THAT(said, HasSubstr("packets are missing in it"));
    const std::string found = casctl({"doctor", "--seconds", "0.1"});
    EXPECT_THAT(found, HasSubstr("the recording pauses: File too large"));
  }
  const int before = call("log.status").at("recorded");
  ASSERT_TRUE(send_until([&] { return !is_paused(); }));
  EXPECT_GT(call("log.status").at("recorded").get<int>(), before);
  const std::string found = casctl({"doctor", "--seconds", "0.1"});
  EXPECT_THAT(found, HasSubstr("the recording has gaps"));
  expect_true_figures(recordings);
  const std::string stopped = casctl({"log", "stop"});
  EXPECT_THAT(stopped, HasSubstr("; missing are "));
}

TEST_F(CasdRecording, DoesNotCountWhatADeletedFileTookAlong) {
  start("tlog: flight, keep: {free_space_min_mib: 0}");
  ASSERT_TRUE(send_until([&] { return call("log.status").at("recorded") > 5; }));
  const std::string deleted = call("log.status").at("file");
  fs::remove(deleted);
  ASSERT_TRUE(send_until([&] { return call("log.status").at("left_out") > 5; }));
  EXPECT_THAT(casd->output(), HasSubstr(deleted + " was deleted while it was written"));
  ASSERT_TRUE(send_until([&] { return call("log.status").at("recorded") > 5; }));
  const std::string found = casctl({"doctor", "--seconds", "0.1"});
  EXPECT_THAT(found, HasSubstr("the recording has gaps"));
  expect_true_figures(recordings);
}

TEST_F(CasdRecording, SaysWhichRecordingACallHasEnded) {
  start("rotate_mib: 0");
  EXPECT_THAT(casctl({"log", "stop"}), HasSubstr("no recording ran"));
  EXPECT_THAT(casctl({"log", "start", "a"}), Not(HasSubstr("ended")));
  const std::string file = call("log.status").at("file");
  EXPECT_THAT(casctl({"log", "start", "b"}), HasSubstr("; ended the recording into " + file));
  EXPECT_TRUE(call("log.stop").contains("ended"));
  EXPECT_FALSE(call("log.stop").contains("ended"));
}

TEST_F(CasdRecording, GoesOnWhenAFullDiskHasRoomAgain) {
  // A disk of its own, which only casd sees; this test looks at it through casd's root.
  const std::string mount =
      "mount -t tmpfs -o size=256k tmpfs " + (fixture.folder / "rec").string();
  fs::create_directory(fixture.folder / "rec");
  ChildProcess probe({"/usr/bin/unshare", "-rm", "/bin/sh", "-c", mount});
  if (probe.wait_exit() != 0) GTEST_SKIP() << "no disk can be mounted here: " << probe.output();
  start("tlog: flight, keep: {free_space_min_mib: 0}",
        {"/usr/bin/unshare", "-rm", "/bin/sh", "-c", mount});
  const fs::path disk = "/proc/" + std::to_string(casd->pid()) + "/root" + recordings.string();

  std::ofstream(disk / "filler") << std::string(200 * 1024, 'x');
  ASSERT_TRUE(send_until([&] { return is_paused(); }));
  EXPECT_EQ(call("log.status").at("paused"), "No space left on device");
  EXPECT_TRUE(casd->prints("pauses: No space left on device")) << casd->output();
  const json full = call("log.status");
  EXPECT_EQ(full.at("recorded").get<std::size_t>(), packets_in(disk));

  fs::remove(disk / "filler");
  ASSERT_TRUE(send_until([&] { return !is_paused(); }));
  EXPECT_TRUE(casd->prints("goes on in"));
  EXPECT_EQ(call("log.status").at("file"), full.at("file")) << "the same file goes on";
  expect_true_figures(disk);
}

TEST_F(CasdRecording, LeavesRoomOnTheDisk) {
  start("tlog: flight, keep: {free_space_min_mib: 1e8}");  // more than any disk has
  ASSERT_TRUE(send_until([&] { return is_paused(); }));
  const json status = call("log.status");
  EXPECT_EQ(status.at("paused"), "less than 100000000 MiB would stay free");
  EXPECT_EQ(status.at("recorded"), 0);
  expect_true_figures(recordings);
}

TEST_F(CasdRecording, RunsWhileAVehicleIsArmedAndKeepsWhatCameBefore) {
  start("tlog: wing, while_armed: true, keep: {free_space_min_mib: 0}");
  mavlink::common::Heartbeat heartbeat{.type = mavlink::common::MavType::kQuadrotor,
                                       .autopilot = mavlink::common::MavAutopilot::kPx4};
  const auto say = [&](bool armed) {
    heartbeat.base_mode = armed ? mavlink::common::MavModeFlag::kSafetyArmed
                                : mavlink::common::MavModeFlag::kCustomModeEnabled;
    fixture.fcu.write(fixture.from_fcu(heartbeat));
    fixture.collect();
  };
  const auto active = [&] { return call("log.status").at("active").get<bool>(); };
  const auto file = [&] { return call("log.status").at("file").get<std::string>(); };
  ASSERT_TRUE(wait_until([&] {
    say(false);
    return call("casd.status").at("vehicles").size() == 1;
  }));
  EXPECT_FALSE(active());
  EXPECT_EQ(call("log.status").at("awaits_arming"), true);
  const std::string idle = casctl({"log", "status"});
  EXPECT_THAT(idle, HasSubstr("not recording until a vehicle is armed"));
  // A sensor packet passes, and the next thing that casd hears is the arming.
  send();
  ASSERT_TRUE(fixture.collect_until([&] { return fixture.at_fcu.count(kHilSensor) == 1; }));

  std::set<std::string> files;
  for (int flight = 0; flight < 2; ++flight) {
    say(true);
    ASSERT_TRUE(wait_until([&] { return active() && !file().empty(); }));
    files.insert(file());
    ASSERT_TRUE(wait_until([&] {
      say(false);
      return !active();
    }));
  }
  EXPECT_EQ(files.size(), 2U);
  casd::TlogReader reader;
  ASSERT_TRUE(reader.open(*files.begin()));
  bool has_what_came_before = false;
  mav::PacketParser parser(mavlink::common::table());
  while (const auto record = reader.next()) {
    parser.reset();
    parser.feed(record->packet, [&](const mav::PacketView& packet) {
      if (packet.message_id == kHilSensor) has_what_came_before = true;
    });
  }
  EXPECT_TRUE(has_what_came_before);
}

/// A vehicle arms, and the disk for its recording does not answer: casd's main thread, which sends
/// commands and feeds the watchdog, goes on.
TEST_F(CasdRecording, ADiskThatHangsDelaysNobodyButTheRecording) {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  GTEST_SKIP() << "sanitizers want to be the first library";
#endif
  const fs::path hang = fixture.folder.write("hang", "");
  start("tlog: wing, while_armed: true, keep: {free_space_min_mib: 0}",
        {"/usr/bin/env", "LD_PRELOAD=" + binary_dir() + "/tests/hanging_open.so",
         "CAS_TEST_HANG=" + hang.string(), "CAS_TEST_HANG_AT=.tlog", "/bin/sh", "-c", "true"});
  mavlink::common::Heartbeat heartbeat{.type = mavlink::common::MavType::kQuadrotor,
                                       .autopilot = mavlink::common::MavAutopilot::kPx4};
  const auto say = [&](bool armed) {
    heartbeat.base_mode = armed ? mavlink::common::MavModeFlag::kSafetyArmed
                                : mavlink::common::MavModeFlag::kCustomModeEnabled;
    fixture.fcu.write(fixture.from_fcu(heartbeat));
    fixture.collect();
  };
  // The disk hangs as long as the test: an answer that comes at all did not wait for it.
  const auto status = [&] { return casd->client().call("log.status", json::object(), kPatience); };
  ASSERT_TRUE(wait_until([&] {
    say(false);
    return call("casd.status").at("vehicles").size() == 1;
  }));
  ASSERT_TRUE(wait_until([&] {
    say(true);
    return fs::exists(hang.string() + ".reached");
  })) << casd->output();
  ASSERT_TRUE(
      wait_until([&] { return status().value("paused", "") == "the disk does not answer"; }));
  EXPECT_TRUE(status().at("active"));
  EXPECT_EQ(status().at("file"), "");
  EXPECT_TRUE(casd->client().call("vehicle.state", json::object(), kPatience).at("armed"));
  send();
  ASSERT_TRUE(fixture.collect_until([&] { return fixture.at_fcu.count(kHilSensor) == 1; }));
  // The flight ends while the disk still hangs; then it answers.
  ASSERT_TRUE(wait_until([&] {
    say(false);
    return status().at("awaits_arming").get<bool>();
  }));
  fs::remove(hang);
  ASSERT_TRUE(wait_until([&] { return !status().at("active").get<bool>(); }));
  EXPECT_GE(status().at("recorded"), 2) << "HEARTBEAT and HIL_SENSOR of the flight";
  EXPECT_EQ(status().at("left_out"), 0);
}

TEST_F(CasdRecording, ADiskThatHangsKeepsOnlyWhoAskedForARecordingWaiting) {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  GTEST_SKIP() << "sanitizers want to be the first library";
#endif
  const fs::path hang = fixture.folder.write("hang", "");
  start("keep: {free_space_min_mib: 0}",
        {"/usr/bin/env", "LD_PRELOAD=" + binary_dir() + "/tests/hanging_open.so",
         "CAS_TEST_HANG=" + hang.string(), "CAS_TEST_HANG_AT=.tlog", "/bin/sh", "-c", "true"});
  ChildProcess asker(
      {binary_dir() + "/bin/casctl", "--address", casd->address(), "log", "start", "mine"});
  ASSERT_TRUE(wait_until([&] { return fs::exists(hang.string() + ".reached"); }));
  EXPECT_EQ(casd->client().call("log.status", json::object(), kPatience).at("file"), "");
  fs::remove(hang);
  EXPECT_EQ(asker.wait_exit(), 0) << asker.output();
  EXPECT_THAT(asker.output(), HasSubstr("recording into "));
}

}  // namespace
}  // namespace cas::test
