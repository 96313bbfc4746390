// SPDX-License-Identifier: BSD-3-Clause
#include "base/os/write_file.hpp"

#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <fstream>
#include <iterator>

#include "base/error.hpp"
#include "base/os/disk_error.hpp"
#include "tests/support/refusal.hpp"
#include "tests/support/temporary_folder.hpp"

namespace cas::base {
namespace {

namespace fs = std::filesystem;

std::string text_of(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

std::ptrdiff_t files_in(const fs::path& folder) {
  return std::distance(fs::directory_iterator(folder), {});
}

TEST(WriteFile, MakesAndReplacesAFileAndLeavesNothingBesideIt) {
  const test::TemporaryFolder folder;
  const fs::path file = folder.path() / "a.txt";
  write_file(file, "one\n");
  EXPECT_EQ(text_of(file), "one\n");
  write_file(file, "two", Durability::kCache);
  EXPECT_EQ(text_of(file), "two");
  EXPECT_EQ(files_in(folder.path()), 1);
}

TEST(WriteFile, ReplacesTheFileAndNotItsContent) {
  const test::TemporaryFolder folder;
  const fs::path file = folder.path() / "a.txt";
  write_file(file, "before");
  std::ifstream reader(file);
  write_file(file, "after");
  EXPECT_EQ(std::string(std::istreambuf_iterator<char>(reader), {}), "before");
}

TEST(WriteFile, KeepsTheModeOfAFile) {
  const test::TemporaryFolder folder;
  const fs::path file = folder.path() / "secret";
  write_file(file, "one");
  ::chmod(file.c_str(), 0600);
  write_file(file, "two");
  struct stat status {};
  ASSERT_EQ(::stat(file.c_str(), &status), 0);
  EXPECT_EQ(status.st_mode & 0777U, 0600U);
}

TEST(WriteFile, LeavesASymlinkWhereItIs) {
  const test::TemporaryFolder folder;
  write_file(folder.path() / "behind", "one");
  fs::create_symlink("behind", folder.path() / "link");
  write_file(folder.path() / "link", "two");
  EXPECT_TRUE(fs::is_symlink(folder.path() / "link"));
  EXPECT_EQ(text_of(folder.path() / "behind"), "two");
}

TEST(WriteFile, RefusesASymlinkToNothing) {
  const test::TemporaryFolder folder;
  const fs::path link = folder.path() / "link";
  fs::create_symlink("behind", link);
  EXPECT_EQ(test::refusal([&] { write_file(link, "one"); }),
            link.string() + ": cannot be written: it is a symlink to nothing");
  EXPECT_TRUE(fs::is_symlink(link));
  EXPECT_FALSE(fs::exists(folder.path() / "behind"));
}

TEST(WriteFile, RefusesASymlinkThatAnotherUserLaid) {
  if (::geteuid() != 0) GTEST_SKIP() << "only root can lay a symlink for another user";
  const test::TemporaryFolder folder;
  const fs::path link = folder.path() / "link";
  write_file(folder.path() / "behind", "one");
  fs::create_symlink("behind", link);
  constexpr uid_t kSomebody = 1234;
  ASSERT_EQ(::lchown(link.c_str(), kSomebody, kSomebody), 0);
  EXPECT_THROW(write_file(link, "two"), ConfigError);
  EXPECT_EQ(text_of(folder.path() / "behind"), "one");
}

TEST(WriteFile, FollowsNoFolderThatAnotherUserLaidAsASymlink) {
  if (::geteuid() != 0) GTEST_SKIP() << "only root can lay a symlink for another user";
  const test::TemporaryFolder folder;
  fs::create_directory(folder.path() / "behind");
  const fs::path link = folder.path() / "link";
  fs::create_directory_symlink("behind", link);
  write_file(link / "a.txt", "one");
  EXPECT_EQ(text_of(folder.path() / "behind/a.txt"), "one");
  constexpr uid_t kSomebody = 1234;
  ASSERT_EQ(::lchown(link.c_str(), kSomebody, kSomebody), 0);
  EXPECT_THROW(write_file(link / "a.txt", "two"), ConfigError);
  EXPECT_EQ(text_of(folder.path() / "behind/a.txt"), "one");
}

TEST(WriteFile, WritesOverNothingThatLiesBesideTheFile) {
  const test::TemporaryFolder folder;
  const fs::path file = folder.path() / "a.txt";
  const fs::path beside = file.string() + "." + std::to_string(::getpid()) + ".new";
  write_file(folder.path() / "victim", "one");
  fs::create_symlink("victim", beside);
  write_file(file, "two");
  EXPECT_EQ(text_of(file), "two");
  EXPECT_EQ(text_of(folder.path() / "victim"), "one");
  EXPECT_TRUE(fs::is_symlink(beside));
}

TEST(WriteFile, WritesIntoWhatIsNoFile) {
  write_file("/dev/null", "gone");
  EXPECT_TRUE(fs::is_character_file("/dev/null"));
}

TEST(WriteFile, SaysWhichFileCannotBeWrittenAndWhy) {
  const test::TemporaryFolder folder;
  const fs::path file = folder.path() / "none" / "a.txt";
  EXPECT_EQ(test::refusal([&] { write_file(file, "one"); }),
            file.string() + ": cannot be written: No such file or directory");
  EXPECT_EQ(files_in(folder.path()), 0);
}

TEST(WriteFile, TellsAFullDiskFromAWrongPlace) {
  EXPECT_THROW(write_file("/dev/full", "x"), DiskError);
  const test::TemporaryFolder folder;
  try {
    write_file(folder / "none/file", "x");
    FAIL() << "it was written";
  } catch (const DiskError& error) {
    FAIL() << error.what();
  } catch (const ConfigError&) {
  }
}

}  // namespace
}  // namespace cas::base
