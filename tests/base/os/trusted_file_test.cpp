// SPDX-License-Identifier: BSD-3-Clause
#include "base/os/trusted_file.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

#include "base/error.hpp"
#include "tests/support/temporary_folder.hpp"

namespace cas::base {
namespace {

namespace fs = std::filesystem;

constexpr uid_t kSomebody = 1234;

struct stat of(uid_t user, gid_t group, mode_t mode) {
  struct stat status {};
  status.st_uid = user;
  status.st_gid = group;
  status.st_mode = S_IFREG | mode;
  return status;
}

TEST(TrustedFile, IsRootsOrTheUsersWork) {
  const gid_t foreign = ::getegid() + kSomebody;
  EXPECT_EQ(why_untrusted(of(0, foreign, 0644)), "");
  EXPECT_EQ(why_untrusted(of(::geteuid(), foreign, 0600)), "");
  EXPECT_EQ(why_untrusted(of(::geteuid(), ::getegid(), 0664)), "") << "a umask of 002";
  EXPECT_NE(why_untrusted(of(::geteuid() + kSomebody, ::getegid(), 0600)), "");
  EXPECT_NE(why_untrusted(of(::geteuid(), foreign, 0664)), "");
  EXPECT_NE(why_untrusted(of(::geteuid(), ::getegid(), 0646)), "");
}

TEST(TrustedFile, LiesInAFolderOfTheSame) {
  const test::TemporaryFolder folder;
  const fs::path file = folder.path() / "boards.yaml";
  std::ofstream(file) << "schema: 1\n";
  EXPECT_NO_THROW(require_trusted(file));
  ::chmod(folder.path().c_str(), 0777);
  EXPECT_THROW(require_trusted(file), ConfigError);
  ::chmod(folder.path().c_str(), 01777);
  EXPECT_NO_THROW(require_trusted(file));
  EXPECT_THROW(require_trusted(folder.path() / "none"), ConfigError);
}

TEST(TrustedFile, LiesBelowNoFolderThatEverybodyMayWriteInto) {
  const test::TemporaryFolder folder;
  const fs::path above = folder.path() / "above";
  const fs::path elsewhere = folder.path() / "elsewhere";
  fs::create_directories(above / "own");
  fs::create_directories(elsewhere);
  const fs::path file = above / "own/boards.yaml";
  const fs::path link = elsewhere / "link.yaml";
  std::ofstream(file) << "schema: 1\n";
  fs::create_symlink(file, link);
  EXPECT_NO_THROW(require_trusted(file));
  ::chmod(above.c_str(), 0777);
  EXPECT_THROW(require_trusted(file), ConfigError);
  EXPECT_THROW(require_kept_folders(file), ConfigError);
  EXPECT_THROW(require_kept_folders(link), ConfigError) << "the symlink's target lies there";
  ::chmod(above.c_str(), 01777);
  EXPECT_NO_THROW(require_trusted(file));
  EXPECT_NO_THROW(require_kept_folders(link));
}

TEST(TrustedFile, IsReachedByNoSymlinkOfAnotherUser) {
  if (::geteuid() != 0) GTEST_SKIP() << "only root can lay a symlink for another user";
  const test::TemporaryFolder folder;
  const fs::path file = folder.path() / "boards.yaml";
  const fs::path link = folder.path() / "link.yaml";
  std::ofstream(file) << "schema: 1\n";
  fs::create_symlink(file, link);
  EXPECT_NO_THROW(require_trusted(link));
  ASSERT_EQ(::lchown(link.c_str(), kSomebody, kSomebody), 0);
  EXPECT_THROW(require_trusted(link), ConfigError);
}

}  // namespace
}  // namespace cas::base
