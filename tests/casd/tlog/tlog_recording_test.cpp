// SPDX-License-Identifier: BSD-3-Clause
#include "casd/tlog/tlog_recording.hpp"

#include <gtest/gtest.h>

#include <filesystem>
#include <limits>
#include <optional>

#include "base/error.hpp"
#include "tests/casd/packets.hpp"
#include "tests/support/file_size_limit.hpp"
#include "tests/support/temporary_folder.hpp"

namespace cas::casd::test {
namespace {

namespace fs = std::filesystem;
using cas::test::FileSizeLimit;
using cas::test::TemporaryFolder;

constexpr std::uint64_t kMib = 1024 * 1024;
constexpr std::uint64_t kGib = 1024 * kMib;

TEST(LackOfRoom, IsWhatTheLimitsSay) {
  struct RoomCase {
    const char* name;
    LogLimits limits;
    LogSpace space;
    std::uint64_t more;
    std::optional<std::string> why;
  };
  const RoomCase rows[] = {
      {"NoLimits", {}, {0, kGib}, kGib, {}},
      {"JustEnoughFree", {64 * kMib, 0}, {65 * kMib, 0}, kMib, {}},
      {"TooLittleFree",
       {64 * kMib, 0},
       {65 * kMib - 1, 0},
       kMib,
       "less than 64 MiB would stay free"},
      {"NobodyKnows", {64 * kMib, 0}, {std::numeric_limits<std::uint64_t>::max(), 0}, kMib, {}},
      {"JustBelowTheMost", {0, 10 * kMib}, {kGib, 9 * kMib}, kMib, {}},
      {"BeyondTheMost",
       {0, 10 * kMib},
       {kGib, 9 * kMib + 1},
       kMib,
       "the recordings have the 10 MiB that they may take"}};
  for (const auto& test : rows) {
    SCOPED_TRACE(test.name);
    EXPECT_EQ(lack_of_room(test.limits, test.space, test.more), test.why);
  }
}

/// So many records of one packet each.
std::vector<std::uint8_t> records(std::size_t count) {
  std::vector<std::uint8_t> all;
  const mav::PacketBuffer heartbeat = packet(mavlink::common::Heartbeat{}, {1, 1});
  for (std::size_t i = 0; i < count; ++i) append_tlog_record(i, heartbeat.view(), all);
  return all;
}

/// The packets in all files of a folder.
std::size_t packets_in(const fs::path& folder) {
  std::size_t count = 0;
  for (const auto& entry : fs::directory_iterator(folder)) {
    TlogReader reader;
    if (!reader.open(entry.path())) continue;
    while (reader.next()) ++count;
    EXPECT_EQ(reader.skipped_bytes(), 0U) << entry.path() << " has a torn record";
  }
  return count;
}

class Recording : public testing::Test {
 protected:
  TlogRecording::Options options(const fs::path& to) const {
    TlogRecording::Options options;
    options.files.folder = to;
    options.files.name = "a";
    return options;
  }
  std::ptrdiff_t files() const {
    return std::distance(fs::directory_iterator(folder.path()), fs::directory_iterator{});
  }

  TemporaryFolder folder;
  TlogRecording recording;
};

TEST_F(Recording, PausesWhileTheDiskTakesNothingAndGoesOnByItself) {
  recording.begin(options(folder.path()), at({}));
  EXPECT_EQ(recording.write(records(10), at({})), 10U);
  {
    const FileSizeLimit full(0);
    EXPECT_EQ(recording.write(records(2), at({})), 0U);
    EXPECT_EQ(recording.pause(), "File too large");
    EXPECT_EQ(recording.write(records(2), at(TlogRecording::kRetryPeriod)), 0U);
  }
  const base::Duration later = TlogRecording::kRetryPeriod + milliseconds(999);
  EXPECT_EQ(recording.write(records(2), at(later)), 0U) << "it is not tried again and again";
  EXPECT_TRUE(recording.pause());
  EXPECT_EQ(recording.write(records(3), at(2 * TlogRecording::kRetryPeriod)), 3U);
  EXPECT_FALSE(recording.pause());
  recording.end();
  EXPECT_EQ(packets_in(folder.path()), 13U);
  EXPECT_EQ(recording.bytes(), records(13).size());
}

TEST_F(Recording, TakesBackTheRecordThatDoesNotFitAndGoesOnInTheNextFile) {
  recording.begin(options(folder.path()), at({}));
  const std::size_t half_a_record = records(1).size() / 2;
  const FileSizeLimit small(records(10).size() + half_a_record);
  EXPECT_EQ(recording.write(records(25), at({})), 25U);
  recording.end();
  EXPECT_EQ(files(), 3);
  EXPECT_EQ(packets_in(folder.path()), 25U);
  EXPECT_EQ(recording.file(), folder / "a.2.tlog");
}

TEST_F(Recording, TellsWhatADeletedFileTookAlongAndGoesOnInTheNext) {
  recording.begin(options(folder / "rec"), at({}));
  EXPECT_EQ(recording.write(records(3), at({})), 3U);
  EXPECT_EQ(recording.leave_deleted(), 0U);
  fs::remove_all(folder / "rec");
  EXPECT_EQ(recording.write(records(2), at({})), 2U) << "the kernel takes them still";
  EXPECT_EQ(recording.leave_deleted(), 5U);
  EXPECT_EQ(recording.leave_deleted(), 0U) << "once";
  EXPECT_EQ(recording.bytes(), 0U);
  EXPECT_EQ(recording.file(), folder / "rec/a.tlog") << "until there is another";
  EXPECT_EQ(recording.write(records(4), at({})), 4U);
  EXPECT_EQ(recording.leave_deleted(), 0U);
  recording.end();
  EXPECT_EQ(recording.file(), folder / "rec/a.1.tlog");
  EXPECT_EQ(packets_in(folder / "rec"), 4U);
  EXPECT_EQ(recording.bytes(), records(4).size());
}

TEST_F(Recording, LeavesNoEmptyFilesBehindWhenNoneTakesAnything) {
  recording.begin(options(folder.path()), at({}));
  EXPECT_EQ(recording.write(records(1), at({})), 1U);
  const FileSizeLimit full(0);
  for (int i = 0; i < 5; ++i) {
    EXPECT_EQ(recording.write(records(1), at(i * TlogRecording::kRetryPeriod)), 0U);
  }
  EXPECT_EQ(files(), 1);
  EXPECT_EQ(recording.file(), folder / "a.tlog");
}

TEST_F(Recording, PausesAtTheSizeOfTheFolderUntilSomethingIsRemoved) {
  constexpr std::size_t kKib = 1024;
  folder.write("old.tlog", std::string(900 * kKib, 'x'));
  folder.write("no_recording", std::string(900 * kKib, 'x'));
  TlogRecording::Options limited = options(folder.path());
  limited.limits.max_bytes = kMib;
  recording.begin(limited, at({}));
  const std::vector<std::uint8_t> batch = records(100 * kKib / records(1).size());
  EXPECT_GT(recording.write(batch, at({})), 0U);
  EXPECT_EQ(recording.write(batch, at({})), 0U);
  EXPECT_EQ(recording.pause(), "the recordings have the 1 MiB that they may take");
  fs::remove(folder / "old.tlog");
  EXPECT_GT(recording.write(batch, at(TlogRecording::kRetryPeriod)), 0U);
  EXPECT_FALSE(recording.pause());
}

TEST_F(Recording, DeletesTheOldestInPlaceOfAPauseWhenItMay) {
  const std::string old(400 * 1024, 'x');
  folder.write("2026-11-01T10-00-00Z-a.tlog", old);
  folder.write("2026-11-02T10-00-00Z-a.tlog", old);
  TlogRecording::Options limited = options(folder.path());
  limited.limits = {.max_bytes = kMib, .delete_oldest = true};
  recording.begin(limited, at({}));
  const std::vector<std::uint8_t> batch = records(old.size() / records(1).size());
  EXPECT_GT(recording.write(batch, at({})), 0U);
  EXPECT_FALSE(fs::exists(folder / "2026-11-01T10-00-00Z-a.tlog"));
  EXPECT_TRUE(fs::exists(folder / "2026-11-02T10-00-00Z-a.tlog"));
  EXPECT_GT(recording.write(batch, at({})), 0U);
  EXPECT_FALSE(fs::exists(folder / "2026-11-02T10-00-00Z-a.tlog"));
  EXPECT_FALSE(recording.pause());
  EXPECT_EQ(recording.write(batch, at({})), 0U) << "nothing is left to delete";
  EXPECT_EQ(recording.pause(), "the recordings have the 1 MiB that they may take");
}

TEST_F(Recording, IsRefusedWhereNoFileCanBeMade) {
  EXPECT_THROW(recording.begin(options(folder / "none" / "deep"), at({})), base::ConfigError);
  recording.begin(options(folder / "made"), at({}));
  EXPECT_FALSE(recording.pause());
  EXPECT_TRUE(fs::exists(folder / "made" / "a.tlog"));
}

TEST_F(Recording, WaitsForItsFolderWhereItInsists) {
  const fs::path to = folder / "none" / "deep";
  TlogRecording::Options insisting = options(to);
  insisting.insist = true;
  recording.begin(insisting, at({}));
  EXPECT_EQ(recording.pause(), "No such file or directory");
  EXPECT_EQ(recording.write(records(1), at(TlogRecording::kRetryPeriod)), 0U);
  fs::create_directories(to);
  EXPECT_EQ(recording.write(records(4), at(2 * TlogRecording::kRetryPeriod)), 4U);
  EXPECT_EQ(packets_in(to), 4U);
}

TEST_F(Recording, WritesOverNothingAndFollowsNoSymlink) {
  folder.write("a.tlog", "mine");
  fs::create_symlink(folder / "victim", folder / "a.1.tlog");
  folder.write("full", "theirs");
  fs::create_symlink(folder / "full", folder / "a.2.tlog");
  recording.begin(options(folder.path()), at({}));
  EXPECT_EQ(recording.write(records(1), at({})), 1U);
  recording.end();
  EXPECT_EQ(recording.file(), folder / "a.3.tlog");
  EXPECT_EQ(TemporaryFolder::read(folder / "a.tlog"), "mine");
  EXPECT_FALSE(fs::exists(folder / "victim"));
  EXPECT_EQ(TemporaryFolder::read(folder / "full"), "theirs");
}

TEST_F(Recording, ThatOverwritesRemovesTheSymlinkAndNotWhatItLeadsTo) {
  folder.write("full", "theirs");
  fs::create_symlink(folder / "full", folder / "a.tlog");
  TlogRecording::Options anew = options(folder.path());
  anew.files.overwrite = true;
  recording.begin(anew, at({}));
  EXPECT_EQ(recording.write(records(2), at({})), 2U);
  recording.end();
  EXPECT_EQ(TemporaryFolder::read(folder / "full"), "theirs");
  EXPECT_FALSE(fs::is_symlink(folder / "a.tlog"));
  EXPECT_EQ(fs::file_size(folder / "a.tlog"), records(2).size());
}

}  // namespace
}  // namespace cas::casd::test
