// SPDX-License-Identifier: BSD-3-Clause
#include "hils/report/results_folder.hpp"

#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <filesystem>

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
  fs::create_directory_symlink(folder.path() / "none", folder.path() / "dangling");
  ASSERT_EQ(::lchown((folder.path() / "dangling").c_str(), kSomebody, kSomebody), 0);
  EXPECT_THROW(make_results_folder(folder.path() / "dangling"), base::ConfigError);
}

}  // namespace
}  // namespace cas::hils
