// SPDX-License-Identifier: BSD-3-Clause
#include "casd/tlog/recorder.hpp"

#include <gtest/gtest.h>

#include <filesystem>
#include <future>
#include <set>

#include "base/error.hpp"
#include "tests/casd/packets.hpp"
#include "tests/support/file_size_limit.hpp"
#include "tests/support/temporary_folder.hpp"
#include "tests/support/wait_until.hpp"

namespace cas::casd::test {
namespace {

using std::chrono::seconds;

TEST(ArmedWindow, IsOpenFromArmingUntilAMomentAfterDisarming) {
  ArmedWindow window;
  EXPECT_FALSE(window.update(false, at({})));
  EXPECT_TRUE(window.update(true, at(seconds(1))));
  EXPECT_TRUE(window.update(true, at(seconds(100))));
  EXPECT_TRUE(window.update(false, at(seconds(100) + milliseconds(500))));
  EXPECT_TRUE(window.update(true, at(seconds(101)))) << "armed again: one flight";
  EXPECT_TRUE(window.update(false, at(seconds(102))));
  EXPECT_TRUE(window.update(false, at(seconds(103) - milliseconds(1))));
  EXPECT_FALSE(window.update(false, at(seconds(103))));
  EXPECT_FALSE(window.update(false, at(seconds(104))));
  EXPECT_TRUE(window.update(true, at(seconds(105))));
}

class RecorderTest : public testing::Test {
 protected:
  RecorderTest() { writer.set_epoch(std::chrono::nanoseconds(0)); }  // stamps are run time

  Recorder make(TlogConfig config) {
    if (config.folder.empty()) config.folder = folder.path();
    return {writer, config};
  }
  void say(base::Duration when) {
    writer.record(packet(mavlink::common::Heartbeat{}, {1, 1}).view(), at(when));
  }
  /// Starts one and waits for the disk.
  static void start(Recorder& recorder, const std::string& name) {
    std::promise<std::string> fault;
    recorder.start(name, {},
                   [&](const auto& why, const TlogStatus&) { fault.set_value(why.value_or("")); });
    EXPECT_EQ(fault.get_future().get(), "");
  }
  /// When its packets came, since at({}).
  std::vector<base::Duration> times(const std::filesystem::path& file) const {
    TlogReader reader;
    EXPECT_TRUE(reader.open(file)) << file;
    std::vector<base::Duration> all;
    while (const auto record = reader.next()) {
      all.push_back(microseconds(record->unix_us) - at({}).time_since_epoch());
    }
    return all;
  }

  cas::test::TemporaryFolder folder;
  TlogWriter writer;
};

TEST_F(RecorderTest, SaysBetweenFlightsWhetherItCouldRecord) {
  folder.write("rec", "a file, not a folder");
  Recorder recorder = make({.folder = folder / "rec", .while_armed = true});
  recorder.begin();
  const auto fault = [&] { return recorder.status(base::steady_now()).paused.value_or(""); };
  EXPECT_TRUE(cas::test::wait_until([&] { return fault() == "Not a directory"; }));
  std::filesystem::remove(folder / "rec");
  EXPECT_TRUE(cas::test::wait_until([&] { return fault().empty(); }));
}

TEST_F(RecorderTest, SaysBetweenFlightsThatALimitIsReached) {
  const auto filler = folder.write("old.tlog", std::string(1024 * 1024, 'x'));
  Recorder recorder = make({.keep = {.max_bytes = 1024 * 1024}, .while_armed = true});
  recorder.begin();
  const auto fault = [&] { return recorder.status(base::steady_now()).paused.value_or(""); };
  EXPECT_TRUE(cas::test::wait_until(
      [&] { return fault() == "the recordings have the 1 MiB that they may take"; }));
  std::filesystem::remove(filler);
  EXPECT_TRUE(cas::test::wait_until([&] { return fault().empty(); }));
}

TEST_F(RecorderTest, SaysBetweenFlightsThatNothingIsLeftToMakeRoom) {
  folder.write("2026-11-01T00-00-00Z-a.tlog", std::string(1024 * 1024, 'x'));
  Recorder recorder =
      make({.keep = {.max_bytes = 1024 * 1024, .delete_oldest = true}, .while_armed = true});
  recorder.begin();
  const auto fault = [&] { return recorder.status(base::steady_now()).paused.value_or(""); };
  folder.write("mine.tlog", std::string(1024 * 1024, 'x'));
  EXPECT_TRUE(cas::test::wait_until([&] {
    return fault().find("no old files would make enough room") != std::string::npos;
  })) << "it looks again and again";
  EXPECT_TRUE(std::filesystem::exists(folder / "2026-11-01T00-00-00Z-a.tlog"));
}

/// Threads of links come in the order of the writer's lock, not of their times.
TEST_F(RecorderTest, TimesNeverGoBackButWithTheClock) {
  Recorder recorder = make({.tlog = "flight", .overwrite = true});
  recorder.begin();
  for (const int ms : {10, 12, 11, 13}) say(milliseconds(ms));
  say(milliseconds(5000));
  say(milliseconds(1));  // a restarted simulation
  recorder.stop();
  EXPECT_EQ(times(folder / "flight.tlog"),
            (std::vector<base::Duration>{milliseconds(10), milliseconds(12), milliseconds(12),
                                         milliseconds(13), milliseconds(5000), milliseconds(1)}));
}

TEST_F(RecorderTest, RecordsAFlightFromBeforeItsArmingUntilAfterItsEnd) {
  Recorder recorder = make({.while_armed = true});
  recorder.begin();
  EXPECT_TRUE(recorder.awaits_arming());
  for (int i = 0; i < 50; ++i) {  // five seconds
    say(i * milliseconds(100));
    recorder.on_vehicles(false, at(i * milliseconds(100)));
  }
  EXPECT_EQ(recorder.status(at({})).file, "");
  recorder.on_vehicles(true, at(seconds(5)));
  say(seconds(5));
  EXPECT_TRUE(recorder.status(at({})).active);
  EXPECT_FALSE(recorder.awaits_arming());
  recorder.on_vehicles(false, at(seconds(6)));
  say(seconds(6) + milliseconds(500));
  recorder.on_vehicles(false, at(seconds(6) + milliseconds(500)));
  EXPECT_TRUE(recorder.status(at({})).active);
  recorder.on_vehicles(false, at(seconds(7)));
  ASSERT_TRUE(cas::test::wait_until([&] { return !recorder.status(at({})).active; }));

  const TlogStatus status = recorder.status(at({}));
  const auto heard = times(status.file);
  ASSERT_GE(heard.size(), 12U);
  EXPECT_LE(heard.front(), seconds(4));
  EXPECT_GE(heard.front(), seconds(3)) << "no more is kept than a stretch and the one before";
  EXPECT_EQ(heard.back(), seconds(6) + milliseconds(500));
  EXPECT_EQ(status.recorded, heard.size());
  EXPECT_EQ(status.left_out, 0U);
}

TEST_F(RecorderTest, GivesEachFlightAFileOfItsOwn) {
  Recorder recorder = make({.tlog = "wing.tlog", .while_armed = true});
  recorder.begin();
  std::set<std::filesystem::path> files;
  for (int flight = 0; flight < 3; ++flight) {
    const base::Duration start = flight * seconds(10);
    recorder.on_vehicles(true, at(start));
    say(start);
    recorder.on_vehicles(false, at(start + seconds(2)));
    recorder.on_vehicles(false, at(start + seconds(4)));
    ASSERT_TRUE(cas::test::wait_until([&] { return !recorder.status(at({})).active; }));
    EXPECT_EQ(times(recorder.status(at({})).file).back(), start);
    files.insert(recorder.status(at({})).file);
  }
  EXPECT_EQ(files.size(), 3U);
  EXPECT_NE(files.begin()->filename().string().find("Z-wing."), std::string::npos);
}

TEST_F(RecorderTest, LeavesARecordingThatSomebodyAskedForAlone) {
  Recorder recorder = make({.while_armed = true});
  recorder.begin();
  start(recorder, "mine");
  const auto file = recorder.status(at({})).file;
  recorder.on_vehicles(true, at({}));
  recorder.on_vehicles(false, at(seconds(1)));
  recorder.on_vehicles(false, at(seconds(5)));
  EXPECT_TRUE(recorder.status(at({})).active);
  EXPECT_EQ(recorder.status(at({})).file, file);
  recorder.stop();
  EXPECT_TRUE(recorder.awaits_arming());
}

TEST_F(RecorderTest, TakesNamesAndNoPaths) {
  Recorder recorder = make({});
  recorder.begin();
  EXPECT_FALSE(recorder.status(at({})).active);
  EXPECT_THROW(start(recorder, "../x"), base::ConfigError);
  start(recorder, "x");
  EXPECT_EQ(recorder.status(at({})).file.parent_path(), folder.path());
}

TEST_F(RecorderTest, CountsWhatTheDiskDidNotTakeAndOnlyWhatItTook) {
  Recorder recorder = make({.tlog = "a"});
  recorder.begin();
  say(seconds(1));
  ASSERT_TRUE(cas::test::wait_until([&] { return recorder.status(at({})).recorded == 1; }));
  {
    const cas::test::FileSizeLimit full(0);
    say(seconds(2));
    ASSERT_TRUE(cas::test::wait_until([&] { return recorder.status(at({})).left_out == 1; }));
    EXPECT_EQ(recorder.status(at({})).paused, "File too large");
    EXPECT_TRUE(recorder.status(at({})).active);
  }
  std::uint64_t said = 2;
  ASSERT_TRUE(cas::test::wait_until([&] {
    say(seconds(3));
    ++said;
    return !recorder.status(at({})).paused;
  }));
  recorder.stop();
  const TlogStatus status = recorder.status(at({}));
  EXPECT_EQ(status.recorded + status.left_out, said);
  std::size_t in_files = 0;
  for (const auto& entry : std::filesystem::directory_iterator(folder.path())) {
    in_files += times(entry.path()).size();
  }
  EXPECT_EQ(status.recorded, in_files);
}

/// Orders that do not wait for each other land in the right files.
TEST_F(RecorderTest, KeepsFlightsApartThatTheDiskHasNotSeenYet) {
  Recorder recorder = make({.tlog = "wing", .while_armed = true});
  recorder.begin();
  for (int flight = 0; flight < 3; ++flight) {
    const base::Duration start = flight * seconds(10);
    recorder.on_vehicles(true, at(start));
    say(start);
    recorder.on_vehicles(false, at(start + seconds(2)));
    say(start + seconds(3));
    recorder.on_vehicles(false, at(start + seconds(4)));
  }
  ASSERT_TRUE(cas::test::wait_until([&] { return !recorder.status(at({})).active; }));
  std::set<std::vector<base::Duration>> flights;
  for (const auto& entry : std::filesystem::directory_iterator(folder.path())) {
    flights.insert(times(entry.path()));
  }
  const auto flight = [](int n) {
    return std::vector<base::Duration>{n * seconds(10), n * seconds(10) + seconds(3)};
  };
  EXPECT_EQ(flights, (std::set<std::vector<base::Duration>>{flight(0), flight(1), flight(2)}));
}

TEST_F(RecorderTest, StandsByAgainAfterARecordingThatCouldNotBegin) {
  Recorder recorder = make({.while_armed = true});
  recorder.begin();
  std::promise<std::string> fault;
  TlogRecording::Options nowhere;
  nowhere.files.folder = folder / "none" / "none";
  nowhere.files.name = "x";
  writer.start(nowhere,
               [&](const auto& why, const TlogStatus&) { fault.set_value(why.value_or("")); });
  EXPECT_NE(fault.get_future().get(), "");
  EXPECT_FALSE(recorder.status(at({})).active);
  EXPECT_TRUE(recorder.awaits_arming());
  EXPECT_TRUE(writer.listens());
}

}  // namespace
}  // namespace cas::casd::test
