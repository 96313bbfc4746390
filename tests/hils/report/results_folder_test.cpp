// SPDX-License-Identifier: BSD-3-Clause
#include "hils/report/results_folder.hpp"

#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <filesystem>
#include <set>
#include <string>
#include <vector>

#include "base/error.hpp"
#include "tests/support/temporary_folder.hpp"

namespace cas::hils {
namespace {

namespace fs = std::filesystem;

constexpr uid_t kSomebody = 1234;

TEST(ResultsFolder, IsMadeAndMayBeReachedByTheUsersSymlink) {
  const test::TemporaryFolder folder;
  EXPECT_NO_THROW(make_results_folder(folder.path() / "a/b/"));
  EXPECT_TRUE(fs::is_directory(folder.path() / "a/b"));
  ::chmod((folder.path() / "a").c_str(), 0777);
  EXPECT_NO_THROW(make_results_folder(folder.path() / "a")) << "one's own";
  fs::create_directory_symlink(folder.path() / "a", folder.path() / "link");
  EXPECT_NO_THROW(make_results_folder(folder.path() / "link"));
}

TEST(ResultsFolder, IsNotLaidByAnotherUser) {
  if (::geteuid() != 0) GTEST_SKIP() << "only root can lay files for another user";
  const test::TemporaryFolder folder;
  const fs::path open = folder.path() / "open";
  fs::create_directory(open);
  ASSERT_EQ(::lchown(open.c_str(), kSomebody, kSomebody), 0);
  EXPECT_NO_THROW(make_results_folder(open)) << "nobody else may write into it";
  const fs::path link = folder.path() / "link";
  fs::create_directory_symlink(open, link);
  ::chmod(open.c_str(), 01777);
  EXPECT_THROW(make_results_folder(open), base::ConfigError);
  EXPECT_THROW(make_results_folder(link), base::ConfigError) << "leads to the same";
  const fs::path own = folder.path() / "own";
  const fs::path theirs = folder.path() / "theirs";
  fs::create_directory(own);
  fs::create_directory_symlink(own, theirs);
  ASSERT_EQ(::lchown(theirs.c_str(), kSomebody, kSomebody), 0);
  EXPECT_THROW(make_results_folder(theirs), base::ConfigError);
  EXPECT_THROW(make_results_folder(theirs / ""), base::ConfigError);
  EXPECT_THROW(make_results_folder(theirs / "a/b"), base::ConfigError);
  EXPECT_FALSE(fs::exists(own / "a"));
  fs::create_directory_symlink(folder.path() / "none", folder.path() / "dangling");
  ASSERT_EQ(::lchown((folder.path() / "dangling").c_str(), kSomebody, kSomebody), 0);
  EXPECT_THROW(make_results_folder(folder.path() / "dangling"), base::ConfigError);
}

TEST(ResultsFolder, IsTheNextThatNobodyHas) {
  const test::TemporaryFolder folder;
  const fs::path out = folder.path() / "out";
  EXPECT_EQ(make_next_folder(out, "hover"), out / "hover");
  EXPECT_EQ(make_next_folder(out, "hover"), out / "hover-2");
  folder.write("out/hover-3", "a file");
  fs::create_symlink("nowhere", out / "hover-4");
  EXPECT_EQ(make_next_folder(out, "hover"), out / "hover-5");
  EXPECT_EQ(make_next_folder(out, "step"), out / "step");
}

TEST(ResultsFolder, IsClearedOfWhatARunLeftAndOfNothingElse) {
  const test::TemporaryFolder folder;
  const auto names = [&folder] {
    std::set<std::string> all;
    for (const auto& entry : fs::recursive_directory_iterator(folder.path())) {
      all.insert(entry.path().lexically_relative(folder.path()).string());
    }
    return all;
  };
  const std::vector<std::string> own{"notes.txt", "plots/mine.png", "run/notes.txt", "truths.csv",
                                     "again/row_1/truth.csv"};
  for (const std::string& file : own) folder.write(file, "a person's");
  const std::set<std::string> kept = names();
  for (const char* const file :
       {"run/hilsim.yaml", "run/casd.yaml", "run/casd_ledger.csv", "run/record.json.gz",
        "run/casd.log", "run/firmware_iris1/etc/parameters", "summary.json", "replay.html",
        "truth.csv", "truth_left.csv", "flight.tlog", "flight_left.ulg", "flight.mcap",
        "sensors/imu.csv", "sensors_left/gps.csv", "plots/track.svg", "plots/left/track.svg",
        "left/board.ulg"}) {
    folder.write(file, "a run's");
  }
  clear_earlier_run(folder.path());
  EXPECT_EQ(names(), kept);
}

TEST(ResultsFolder, WithoutARunIsClearedOfVerdictsAlone) {
  const test::TemporaryFolder folder;
  const fs::path truth = folder.write("truth.csv", "a person's");
  const fs::path verdict = folder.write("summary.json", "passed");
  clear_earlier_run(folder.path());
  EXPECT_TRUE(fs::exists(truth));
  EXPECT_FALSE(fs::exists(verdict));
}

TEST(ResultsFolder, IsClearedWithoutASymlinkBeingFollowed) {
  const test::TemporaryFolder folder;
  const fs::path elsewhere = folder.write("elsewhere/imu.csv", "a person's");
  folder.write("out/run/hilsim.yaml", "a run's");
  fs::create_directory_symlink(folder.path() / "elsewhere", folder.path() / "out/sensors");
  clear_earlier_run(folder.path() / "out");
  EXPECT_TRUE(fs::exists(elsewhere));
}

}  // namespace
}  // namespace cas::hils
