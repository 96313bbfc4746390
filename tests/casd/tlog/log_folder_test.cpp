// SPDX-License-Identifier: BSD-3-Clause
#include "casd/tlog/log_folder.hpp"
#include "casd/autopilot_log/log_files.hpp"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/file.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <filesystem>
#include <future>
#include <set>
#include <utility>
#include <vector>

#include "base/os/descriptor.hpp"
#include "base/os/file_lock.hpp"
#include "casd/tlog/tlog_files.hpp"
#include "casd/tlog/tlog_name.hpp"
#include "tests/support/temporary_folder.hpp"

namespace cas::casd::test {
namespace {

namespace fs = std::filesystem;
using Names = std::vector<std::string>;

const std::string kOld = "2026-11-20T10-00-00Z-a.tlog";
const std::string kMiddle = "2026-11-21T10-00-00Z.tlog";
const std::string kNew = "2026-11-22T10-00-00Z-a.tlog";

std::set<std::string> names_in(const fs::path& folder) {
  std::set<std::string> names;
  for (const auto& entry : fs::directory_iterator(folder)) names.insert(entry.path().filename());
  return names;
}

/// Gives all files one time of the last write, so that their names decide.
void write_all_at_once(const fs::path& folder) {
  const auto now = fs::file_time_type::clock::now();
  for (const auto& entry : fs::directory_iterator(folder)) {
    if (entry.is_regular_file() && !entry.is_symlink()) fs::last_write_time(entry, now);
  }
}

class OldRecordings : public testing::Test {
 protected:
  OldRecordings() {
    for (const std::string& name : {kNew, kOld, kMiddle}) folder_.write(name, "x");
  }
  Names remove(std::size_t keep, const std::string& current = "") {
    write_all_at_once(folder_.path());
    return LogFolder(folder_.path()).remove_oldest(keep, current);
  }
  cas::test::TemporaryFolder folder_;
};

TEST_F(OldRecordings, GoByDateThenByNumber) {
  folder_.write("2026-11-20T10-00-00Z-a.2.tlog", "x");
  folder_.write("2026-11-20T10-00-00Z-a.10.tlog", "x");
  EXPECT_EQ(remove(5), Names{});
  EXPECT_EQ(remove(2),
            (Names{kOld, "2026-11-20T10-00-00Z-a.2.tlog", "2026-11-20T10-00-00Z-a.10.tlog"}));
  EXPECT_EQ(names_in(folder_.path()), (std::set<std::string>{kMiddle, kNew}));
}

TEST_F(OldRecordings, GoByTheirLastWriteWhateverTheClockSaidAtFirst) {
  write_all_at_once(folder_.path());
  fs::last_write_time(folder_ / kOld, fs::file_time_type::clock::now() + std::chrono::hours(1));
  const LogFolder folder(folder_.path());
  EXPECT_EQ(folder.remove_oldest(1, ""), (Names{kMiddle, kNew}));
}

TEST_F(OldRecordings, AReaderKeepsNone) {
  const base::Descriptor reader(::open((folder_ / kOld).c_str(), O_RDONLY | O_CLOEXEC));
  ASSERT_TRUE(reader);
  ASSERT_EQ(::flock(reader.get(), LOCK_SH | LOCK_NB), 0);
  struct flock shared = base::whole_file(F_RDLCK);
  ASSERT_EQ(::fcntl(reader.get(), F_OFD_SETLK, &shared), 0);
  EXPECT_EQ(remove(2), Names{kOld});
}

TEST_F(OldRecordings, OthersFilesSymlinksAndTheCurrentOneStay) {
  const fs::path victim = folder_.write("victim", "theirs");
  for (const char* name : {"flight.tlog", "2026-11-20.tlog", "2026-11-20T10-00-00Z-a.txt",
                           "2026-11-2xT10-00-00Z-a.tlog", "2026-11-20T10-00-00Zb.tlog"}) {
    folder_.write(name, "x");
  }
  fs::create_symlink(victim, folder_ / "2026-11-19T10-00-00Z-a.tlog");
  fs::create_directory(folder_ / "2026-11-18T10-00-00Z-a.tlog");
  const std::set<std::string> all = names_in(folder_.path());
  EXPECT_EQ(remove(1, kOld), (Names{kMiddle, kNew}));
  std::set<std::string> left = all;
  left.erase(kMiddle);
  left.erase(kNew);
  EXPECT_EQ(names_in(folder_.path()), left);
  EXPECT_EQ(cas::test::TemporaryFolder::read(victim), "theirs");
}

TEST_F(OldRecordings, AFileThatIsBeingWrittenStays) {
  const LogFolder folder(folder_.path());
  const std::string written = "2026-11-01T10-00-00Z-other.tlog";
  {
    const base::Descriptor file = folder.make(written);
    ASSERT_TRUE(file);
    EXPECT_EQ(remove(1), (Names{kOld, kMiddle, kNew}));
  }
  folder_.write(kNew, "x");
  EXPECT_EQ(remove(1), Names{written});
}

TEST_F(OldRecordings, GoWhenARecordingBeginsAndWhenItContinues) {
  const std::vector<std::uint8_t> record(100);  // no packet: one record, whatever it holds
  TlogFiles files;
  ASSERT_TRUE(files.begin({.folder = folder_.path(),
                           .name = "2026-11-23T10-00-00Z-a",
                           .rotation = {.max_bytes = 100},
                           .max_files = 2},
                          {}));
  EXPECT_EQ(names_in(folder_.path()), (std::set<std::string>{kNew, "2026-11-23T10-00-00Z-a.tlog"}));
  files.write(record, {});
  files.write(record, {});
  files.write(record, {});
  files.close();
  EXPECT_EQ(names_in(folder_.path()), (std::set<std::string>{"2026-11-23T10-00-00Z-a.1.tlog",
                                                             "2026-11-23T10-00-00Z-a.2.tlog"}));
}

TEST_F(OldRecordings, MakeRoomAsFarAsItIsNeeded) {
  const LogFolder folder(folder_.path());
  folder_.write("mine.tlog", "xxxx");  // counts, and stays
  write_all_at_once(folder_.path());
  const LogLimits limits{.free_space_min_bytes = 0, .max_bytes = 8, .delete_oldest = true};
  EXPECT_EQ(folder.make_room(limits, 1, ""), Names{});
  EXPECT_EQ(folder.make_room(limits, 3, ""), (Names{kOld, kMiddle}));
  EXPECT_EQ(folder.make_room(limits, 4, kNew), Names{}) << "it is written";
  EXPECT_EQ(folder.make_room(limits, 4, ""), Names{kNew});
  EXPECT_TRUE(fs::exists(folder_ / "mine.tlog"));
}

TEST_F(OldRecordings, StayWhereAllOfThemWouldNotSuffice) {
  const LogFolder folder(folder_.path());
  const LogLimits small{.free_space_min_bytes = 0, .max_bytes = 8, .delete_oldest = true};
  EXPECT_EQ(folder.make_room(small, 9, ""), Names{});
  EXPECT_EQ(folder.lack(small, 9, ""),
            "the recordings have the 0 MiB that they may take, and no old files would make enough "
            "room");
  EXPECT_EQ(folder.lack(small, 8, ""), std::nullopt);
  const LogLimits others{.free_space_min_bytes = std::uint64_t{1} << 60U, .delete_oldest = true};
  EXPECT_EQ(folder.make_room(others, 1, ""), Names{}) << "another program fills the disk";
  EXPECT_EQ(names_in(folder_.path()).size(), 3U);
}

TEST(DatedTlog, IsAFileThatCasdNamed) {
  EXPECT_TRUE(is_dated(tlog_file_name(dated_tlog_name({}, "x"), 3)));
  EXPECT_TRUE(is_dated(tlog_file_name(dated_tlog_name({}, ""), 0)));
  for (const char* other :
       {"", ".tlog", "x.tlog", "2026-11-20T10-00-00Z", "2026-11-20T10-00-00.tlog"}) {
    EXPECT_FALSE(is_dated(other)) << other;
  }
}

TEST(LogFolder, RemovesTheOldestOfItsOwnKindAlone) {
  const cas::test::TemporaryFolder place;
  for (const char* name :
       {"2026-11-20T10-00-00Z-v1.ulg", "2026-11-20T10-00-00Z-v1.1.ulg",
        "2026-11-21T10-00-00Z-v2.bin", "2026-11-22T10-00-00Z-v1.ulg", "2026-11-19T10-00-00Z-a.tlog",
        "2026-11-19T10-00-00Z-v1.ulg.gz", "2026-11-19T10-00-00Z-crash.ulg", "old.ulg"}) {
    place.write(name, "x");
  }
  write_all_at_once(place.path());
  const LogFolder folder(place.path(), {".ulg", ".bin"}, is_autopilot_log);
  EXPECT_EQ(folder.look(true).used_bytes, 6U);
  EXPECT_EQ(
      folder.remove_oldest(2, "2026-11-22T10-00-00Z-v1.ulg"),
      (std::vector<std::string>{"2026-11-20T10-00-00Z-v1.ulg", "2026-11-20T10-00-00Z-v1.1.ulg"}));
  EXPECT_TRUE(fs::exists(place / "2026-11-19T10-00-00Z-a.tlog"));
  EXPECT_TRUE(fs::exists(place / "2026-11-19T10-00-00Z-crash.ulg"));
  EXPECT_TRUE(fs::exists(place / "old.ulg"));
}

TEST(LogFolder, SaysWhetherItTakesFilesToSeveralThreadsAtOnce) {
  for (int i = 0; i < 50; ++i) {
    const cas::test::TemporaryFolder place;
    const LogFolder folder(place / "rec");
    std::vector<std::future<bool>> answers;
    for (int n = 0; n < 4; ++n) {
      answers.push_back(std::async(std::launch::async, [&] { return folder.takes_files(); }));
    }
    for (std::future<bool>& answer : answers) EXPECT_TRUE(answer.get());
    EXPECT_TRUE(fs::is_empty(folder.path())) << "nothing is left of it";
  }
}

TEST(LogFolder, IsNotWhereAnotherUsersSymlinkLeads) {
  if (::geteuid() != 0) GTEST_SKIP() << "only root can lay files for another user";
  constexpr uid_t kSomebody = 65534;
  const cas::test::TemporaryFolder place;
  fs::create_directory(place / "real");
  for (const auto& [name, owner] : {std::pair{"own", uid_t{0}}, {"theirs", kSomebody}}) {
    fs::create_directory_symlink(place / "real", place / name);
    ASSERT_EQ(::lchown((place / name).c_str(), owner, owner), 0);
    for (const fs::path& path : {place / name, place / name / ""}) {
      EXPECT_EQ(LogFolder(path).takes_files(), owner == 0) << path;
      if (owner != 0) {
        EXPECT_EQ(errno, ELOOP) << path;
      }
    }
  }
}

TEST(LogFolder, SaysWhyItTakesNoFiles) {
  const cas::test::TemporaryFolder place;
  place.write("file", "x");
  fs::create_symlink(place / "nowhere", place / "leads_nowhere");
  for (const auto& [name, error] :
       {std::pair{"file", ENOTDIR}, {"leads_nowhere", ENOENT}, {"no/parent", ENOENT}}) {
    EXPECT_FALSE(LogFolder(place / name).takes_files());
    EXPECT_EQ(errno, error) << name;
  }
}

}  // namespace
}  // namespace cas::casd::test
