// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <numeric>
#include <string>
#include <string_view>

#include "casd/tlog/tlog_files.hpp"
#include "casd/tlog/tlog_read_ahead.hpp"
#include "mavlink/common/all.hpp"
#include "tests/loopback/casd_fixture.hpp"

namespace cas::test {
namespace {

using casd::TlogFiles;
using casd::TlogReader;
using std::chrono::milliseconds;
using std::chrono::seconds;

constexpr std::uint64_t kStart_us = 1'700'000'000'000'000;

std::vector<std::uint8_t> record(std::uint64_t stamp_us, std::span<const std::uint8_t> packet) {
  std::vector<std::uint8_t> bytes;
  for (int shift = 56; shift >= 0; shift -= 8) {
    bytes.push_back(static_cast<std::uint8_t>(stamp_us >> static_cast<unsigned>(shift)));
  }
  bytes.insert(bytes.end(), packet.begin(), packet.end());
  return bytes;
}

class Tlog : public testing::Test {
 protected:
  /// Records of HIL_SENSOR number 1 to `last`, 10 ms apart.
  std::vector<std::uint8_t> records(std::uint64_t last) {
    std::vector<std::uint8_t> all;
    for (std::uint64_t i = 1; i <= last; ++i) {
      const auto one = record(kStart_us + i * 10'000, fixture.from_sim(hil_sensor(i)));
      all.insert(all.end(), one.begin(), one.end());
    }
    return all;
  }
  std::size_t count(const std::filesystem::path& file) const {
    TlogReader reader;
    if (!reader.open(file)) return 0;
    std::size_t n = 0;
    while (reader.next()) ++n;
    EXPECT_EQ(reader.skipped_bytes(), 0U) << file;
    return n;
  }
  TlogFiles::Options named_a(const casd::TlogRotation& rotation) const {
    return {.folder = fixture.folder.path(), .name = "a", .rotation = rotation, .overwrite = false};
  }
  void write(const std::string& name, std::span<const std::uint8_t> bytes) const {
    std::ofstream(fixture.folder / name, std::ios::binary)
        .write(reinterpret_cast<const char*>(bytes.data()),
               static_cast<std::streamsize>(bytes.size()));
  }
  void replay(const std::string& more) {
    fixture.start(R"(schema: 1
links:
  - {name: sim, type: udp, local: "127.0.0.1:0", remote: "$SIM"}
  - {name: log, type: tlog, file: "$DIR/in.tlog")" +
                  more + "}\n");
  }

  CasdFixture fixture;
  const base::RunTime now{seconds(100)};
};

TEST_F(Tlog, GoesOnInTheNextFileAtItsSizeAndKeepsTheNewest) {
  TlogFiles files;
  const auto all = records(100);
  const std::uint64_t size = all.size() / 10;  // ten records a file, give or take their lengths
  ASSERT_TRUE(files.begin(named_a({.max_bytes = size, .max_age = {}, .keep = 3}), now));
  ASSERT_EQ(files.write(all, now), all.size());
  files.close();
  EXPECT_FALSE(std::filesystem::exists(fixture.folder / "a.tlog"));
  std::size_t kept = 0;
  for (const auto& entry : std::filesystem::directory_iterator(fixture.folder.path())) {
    if (entry.path().extension() != ".tlog") continue;
    EXPECT_LE(entry.file_size(), size);
    EXPECT_GE(count(entry.path()), 1U);
    ++kept;
  }
  EXPECT_EQ(kept, 3U);
  TlogReader last;
  ASSERT_TRUE(last.open(files.current()));
  std::uint64_t newest_us = 0;
  while (const auto next = last.next()) newest_us = next->unix_us;
  EXPECT_EQ(newest_us, kStart_us + 100 * 10'000);
}

TEST_F(Tlog, GoesOnInTheNextFileAtItsAge) {
  TlogFiles files;
  ASSERT_TRUE(files.begin(named_a({.max_bytes = 0, .max_age = seconds(60), .keep = 0}), now));
  ASSERT_GT(files.write(records(5), now + seconds(59)), 0U);
  ASSERT_GT(files.write(records(3), now + seconds(60)), 0U);
  files.close();
  EXPECT_EQ(count(fixture.folder / "a.tlog"), 5U);
  EXPECT_EQ(count(fixture.folder / "a.1.tlog"), 3U);
}

TEST_F(Tlog, WritesOverNoFileOfBefore) {
  write("a.tlog", {});
  write("a.1.tlog", {});
  write("a.3.tlog", {});
  TlogFiles files;
  ASSERT_TRUE(files.begin(named_a({.max_bytes = 1, .max_age = {}, .keep = 0}), now));
  EXPECT_EQ(files.current(), fixture.folder / "a.2.tlog");
  ASSERT_GT(files.write(records(2), now), 0U);
  EXPECT_EQ(files.current(), fixture.folder / "a.4.tlog");
}

TEST_F(Tlog, ReadsAroundWhatIsNoRecord) {
  auto bytes = records(3);
  bytes.insert(bytes.begin(), {1, 2, 3});
  bytes.insert(bytes.end(), {9, 9, 9, 9, 9, 9, 9, 9, 0xFD, 200});  // cut off
  write("in.tlog", bytes);
  TlogReader reader;
  ASSERT_TRUE(reader.open(fixture.folder / "in.tlog"));
  std::size_t n = 0;
  while (reader.next()) ++n;
  EXPECT_EQ(n, 3U);
  EXPECT_GE(reader.skipped_bytes(), 3U);
}

TEST_F(Tlog, PlaysItsPacketsAsTheyWereRecorded) {
  write("in.tlog", records(200));
  replay(", speed: 100");
  ASSERT_TRUE(fixture.collect_until([&] { return fixture.at_sim.count(kHilSensor) == 200; }));
  std::vector<std::uint64_t> all(200);
  std::iota(all.begin(), all.end(), std::uint64_t{1});
  EXPECT_EQ(numbers(fixture.at_sim, kHilSensor), all);
  EXPECT_TRUE(wait_until([&] { return fixture.status("log").state == casd::LinkState::kDown; }));
  EXPECT_EQ(fixture.status("log").rx.lost, 0U);
}

TEST_F(Tlog, KeepsTheRhythmTimesItsSpeed) {
  auto bytes = record(kStart_us, fixture.from_sim(hil_sensor(1)));
  const auto second = record(kStart_us + 1'000'000, fixture.from_sim(hil_sensor(2)));
  bytes.insert(bytes.end(), second.begin(), second.end());
  write("in.tlog", bytes);
  replay(", speed: 10");
  const base::RunTime started = base::steady_now();
  ASSERT_TRUE(fixture.collect_until([&] { return fixture.at_sim.count(kHilSensor) == 2; }));
  EXPECT_GE(base::steady_now() - started, milliseconds(90));
}

/// A station's arm and disarm commands for vehicle 1, then a status text of another vehicle.
class TlogOfAStation : public Tlog {
 protected:
  TlogOfAStation() {
    using namespace mavlink::common;
    add(station_(Heartbeat{.type = MavType::kGcs, .autopilot = MavAutopilot::kInvalid}));
    CommandLong arm;
    arm.target_system = arm.target_component = 1;
    arm.command = MavCmd::kComponentArmDisarm;
    arm.param1 = 1;
    add(station_(arm));
    arm.param1 = 0;
    add(station_(arm));
    add(other_(Statustext{}));
    write("in.tlog", log_);
  }
  /// Plays it while vehicle 1, in HIL or not, is heard; until the status text has come.
  testing::AssertionResult played(const std::string& more, bool in_hil) {
    replay(more);
    const bool came = fixture.collect_until([&] {
      say(in_hil);
      return fixture.at_sim.count(mavlink::common::Statustext::kId) > 0;
    });
    return came ? testing::AssertionSuccess() : testing::AssertionFailure() << "nothing played";
  }
  /// Sends the vehicle's HEARTBEAT.
  void say(bool in_hil) {
    using namespace mavlink::common;
    Heartbeat word{
        .autopilot = MavAutopilot::kPx4,
        .base_mode = in_hil ? MavModeFlag::kHilEnabled : MavModeFlag::kCustomModeEnabled};
    fixture.sim.send(fixture.from_fcu(word));
  }
  std::uint64_t held_back() const {
    constexpr auto kNotHil = static_cast<std::size_t>(casd::Route::Decision::kNotHil);
    return fixture.status("log").rx.decisions[kNotHil];
  }
  std::size_t commands() { return fixture.at_sim.count(mavlink::common::CommandLong::kId); }

 private:
  /// The first record leaves time for the vehicle to be heard.
  void add(std::span<const std::uint8_t> packet) {
    const std::uint64_t at_us = kStart_us + (log_.empty() ? 0 : 1'000'000);
    const auto one = record(at_us, packet);
    log_.insert(log_.end(), one.begin(), one.end());
  }
  mav::Encoder station_{{255, 190}};
  mav::Encoder other_{{9, 1}};
  std::vector<std::uint8_t> log_;
};

TEST_F(TlogOfAStation, PlaysWhatVehiclesSaidAlone) {
  ASSERT_TRUE(played("", true));
  EXPECT_EQ(commands(), 0U);
  EXPECT_EQ(fixture.status("log").rx.not_accepted, 3U);
}

TEST_F(TlogOfAStation, PlaysCommandsToAVehicleInHilWhereToldTo) {
  ASSERT_TRUE(played(", commands: true", true));
  EXPECT_EQ(commands(), 2U);
}

TEST_F(TlogOfAStation, ArmsNoVehicleThatIsNotInHil) {
  ASSERT_TRUE(played(", commands: true", false));
  EXPECT_EQ(commands(), 1U);  // the disarm
  EXPECT_EQ(held_back(), 1U);
}

TEST_F(TlogOfAStation, WhatIsHeldBackIsToldOnce) {
  testing::internal::CaptureStderr();
  ASSERT_TRUE(played(", commands: true, repeat: true, speed: 10", false));
  EXPECT_TRUE(fixture.collect_until([&] {
    say(false);
    return held_back() >= 3;
  }));
  const std::string said = testing::internal::GetCapturedStderr();
  constexpr std::string_view kLine = "and others like it are held back";
  const std::size_t first = said.find(kLine);
  ASSERT_NE(first, std::string::npos) << said;
  EXPECT_EQ(said.find(kLine, first + 1), std::string::npos) << said;
}

TEST_F(TlogOfAStation, PlaysAllWhereToldTo) {
  ASSERT_TRUE(played(", commands: true, to_not_hil: all", false));
  EXPECT_EQ(commands(), 2U);
}

TEST_F(Tlog, PlaysOnInItsRhythmWhereTheRecordersClockWasSet) {
  constexpr std::uint64_t kRecords = 60;
  constexpr std::uint64_t kStep_us = 50'000;
  const auto stamp = [](std::uint64_t i) -> std::uint64_t {
    if (i < 20) return 86'400'000'000 + i * kStep_us;     // 1970, until it hears NTP
    if (i == 30) return kStart_us + 315'360'000'000'000;  // a damaged one
    if (i < 40) return kStart_us + i * kStep_us;
    return kStart_us - 3'600'000'000 + i * kStep_us;  // set back by an hour
  };
  std::vector<std::uint8_t> bytes;
  for (std::uint64_t i = 0; i < kRecords; ++i) {
    const auto one = record(stamp(i), fixture.from_sim(hil_sensor(i + 1)));
    bytes.insert(bytes.end(), one.begin(), one.end());
  }
  write("in.tlog", bytes);
  replay(", speed: 10");
  ASSERT_TRUE(fixture.collect_until([&] { return fixture.at_sim.count(kHilSensor) >= 1; }));
  const base::RunTime started = base::steady_now();
  ASSERT_TRUE(fixture.collect_until([&] { return fixture.at_sim.count(kHilSensor) == kRecords; }));
  // 2.95 s of flight; each of the four steps costs at most one period.
  EXPECT_GE(base::steady_now() - started, milliseconds(200)) << "a burst";
}

TEST_F(Tlog, ADamagedRecordCostsNoOtherOne) {
  constexpr std::uint64_t kStartByte_us = 1'790'000'000'000'000;  // its stamps hold 0xFE
  std::vector<std::uint8_t> bytes;
  for (std::uint64_t i = 1; i <= 60; ++i) {
    auto one = record(kStartByte_us + i * 20'000, fixture.from_sim(hil_sensor(i)));
    if (i == 31) one.resize(25);
    bytes.insert(bytes.end(), one.begin(), one.end());
  }
  write("in.tlog", bytes);
  replay(", speed: 100");
  ASSERT_TRUE(fixture.collect_until([&] { return fixture.at_sim.count(kHilSensor) == 59; }));
  const auto played = numbers(fixture.at_sim, kHilSensor);
  EXPECT_EQ(std::ranges::count(played, std::uint64_t{31}), 0);
}

TEST_F(Tlog, StartsAgainWhereToldTo) {
  write("in.tlog", records(5));
  replay(", speed: 1000, repeat: true");
  EXPECT_TRUE(fixture.collect_until([&] { return fixture.at_sim.count(kHilSensor) >= 15; }));
}

/// Bytes that are no record, as a file has that lost blocks when the power failed.
void append_zeros(const std::filesystem::path& file, std::uintmax_t bytes) {
  std::error_code error;
  const auto size = std::filesystem::file_size(file, error);
  std::filesystem::resize_file(file, (error ? 0 : size) + bytes);
}

TEST_F(Tlog, PlaysOnBehindAHole) {
  write("in.tlog", records(3));
  append_zeros(fixture.folder / "in.tlog", 8U << 20U);
  const auto more = records(5);
  std::ofstream(fixture.folder / "in.tlog", std::ios::binary | std::ios::app)
      .write(reinterpret_cast<const char*>(more.data()), static_cast<std::streamsize>(more.size()));
  replay("");
  EXPECT_TRUE(fixture.collect_until([&] { return fixture.at_sim.count(kHilSensor) == 8; }));
}

TEST_F(Tlog, ZerosOfManyMegabytesHoldUpNoOtherLink) {
  write("in.tlog", records(3));
  append_zeros(fixture.folder / "in.tlog", std::uintmax_t{16} << 30U);  // no byte is written
  const std::string topology = kHilTopology;
  fixture.start(topology.substr(0, topology.find("routes:")) +
                "  - {name: log, type: tlog, file: $DIR/in.tlog}\n" +
                topology.substr(topology.find("routes:")));
  for (std::uint64_t i = 1; i <= 200; ++i) {
    fixture.sim.send(fixture.from_sim(hil_sensor(i)));
    ASSERT_TRUE(fixture.collect_until([&] { return fixture.at_fcu.count(kHilSensor) == i; }));
  }
  EXPECT_EQ(fixture.status("log").state, casd::LinkState::kUp) << "they waited for its end";
}

TEST_F(Tlog, AFileWithoutAPacketIsReadOnce) {
  write("in.tlog", {});
  append_zeros(fixture.folder / "in.tlog", 8U << 20U);
  replay(", repeat: true");
  ASSERT_TRUE(wait_until([&] { return fixture.status("log").endpoint == "holds no packet"; }));
  write("in.tlog", records(3));
  constexpr auto kLongestRetry = std::chrono::seconds(1);  // of a link that is opened again
  EXPECT_FALSE(wait_until([&] { return fixture.status("log").endpoint != "holds no packet"; },
                          2 * kLongestRetry));
}

TEST_F(Tlog, ReadingAheadGivesWhatLiesBeforeAHoleAndTellsTheEnd) {
  write("in.tlog", records(3));
  append_zeros(fixture.folder / "in.tlog", 1U << 20U);
  casd::TlogReadAhead log(fixture.folder / "in.tlog");
  std::size_t count = 0;
  ASSERT_TRUE(wait_until([&] {
    while (log.next()) ++count;
    return log.ended();
  }));
  EXPECT_EQ(count, 3U);
  EXPECT_GT(log.skipped_bytes(), 1'000'000U);
  EXPECT_FALSE(log.unreadable());
}

TEST_F(Tlog, ReadingAheadTellsOfAFileThatCannotBeOpened) {
  casd::TlogReadAhead log(fixture.folder / "missing.tlog");
  ASSERT_TRUE(wait_until([&] { return !log.next() && log.ended(); }));
  EXPECT_TRUE(log.unreadable());
}

TEST_F(Tlog, ReadingAheadCanBeAbandoned) {
  write("in.tlog", records(50'000));  // many pieces: the thread waits with the second one
  for (int i = 0; i < 100; ++i) casd::TlogReadAhead(fixture.folder / "in.tlog").next();
  casd::TlogReadAhead log(fixture.folder / "in.tlog");
  std::size_t count = 0;
  ASSERT_TRUE(wait_until([&] {
    while (log.next()) ++count;
    return log.ended();
  }));
  EXPECT_EQ(count, 50'000U);
}

}  // namespace
}  // namespace cas::test
