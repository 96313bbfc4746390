// SPDX-License-Identifier: BSD-3-Clause
#include "base/os/confine_files.hpp"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <functional>

#include "base/os/descriptor.hpp"
#include "tests/support/temporary_folder.hpp"

namespace cas::base {
namespace {

constexpr int kNoLandlock = 100;

/// What `look` returns in a process of its own that is confined, below 100; or kNoLandlock.
int in_confined_process(FileUse use, const std::vector<std::filesystem::path>& places,
                        const std::function<int()>& look) {
  const pid_t child = ::fork();
  if (child == 0) ::_exit(confine_files(use, places) ? look() : kNoLandlock);
  int status = 0;
  ::waitpid(child, &status, 0);
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

/// 0, or the errno of opening the file.
int error_of_opening(const std::filesystem::path& file, int flags) {
  const Descriptor opened(::open(file.c_str(), flags | O_CLOEXEC, 0600));
  return opened ? 0 : errno;
}

class ConfineFiles : public testing::Test {
 protected:
  ConfineFiles() {
    std::filesystem::create_directory(own_);
    std::filesystem::create_directory(other_);
    folder_.write("own/file", "own");
    folder_.write("other/file", "other");
    if (in_confined_process(FileUse::kWrite, {}, [] { return 0; }) == kNoLandlock) {
      no_landlock_ = true;
    }
  }
  void SetUp() override {
    if (no_landlock_) GTEST_SKIP() << "this kernel has no Landlock";
  }

  cas::test::TemporaryFolder folder_;
  std::filesystem::path own_ = folder_ / "own";
  std::filesystem::path other_ = folder_ / "other";
  bool no_landlock_ = false;
};

TEST_F(ConfineFiles, WritesWhereItMayAndReadsEverywhere) {
  const auto error = [&](const std::filesystem::path& file, int flags) {
    return in_confined_process(FileUse::kWrite, {own_},
                               [&] { return error_of_opening(file, flags); });
  };
  EXPECT_EQ(error(own_ / "new", O_WRONLY | O_CREAT), 0);
  EXPECT_EQ(error(own_ / "file", O_WRONLY | O_TRUNC), 0);
  EXPECT_EQ(error(other_ / "new", O_WRONLY | O_CREAT), EACCES);
  EXPECT_EQ(error(other_ / "file", O_WRONLY), EACCES);
  EXPECT_EQ(error(other_ / "file", O_RDONLY), 0);
}

TEST_F(ConfineFiles, ReadsWhereItMayAndWritesEverywhere) {
  const auto error = [&](const std::filesystem::path& file, int flags) {
    return in_confined_process(FileUse::kRead, {own_, other_ / "file", other_ / "no_such_file"},
                               [&] { return error_of_opening(file, flags); });
  };
  EXPECT_EQ(error(own_ / "file", O_RDONLY), 0);
  EXPECT_EQ(error(other_ / "file", O_RDONLY), 0);
  EXPECT_EQ(error(other_, O_RDONLY | O_DIRECTORY), EACCES);
  EXPECT_EQ(error(folder_.path(), O_RDONLY | O_DIRECTORY), EACCES);
  EXPECT_EQ(error(other_ / "new", O_WRONLY | O_CREAT), 0);
}

TEST_F(ConfineFiles, CallsAddUp) {
  EXPECT_EQ(in_confined_process(FileUse::kRead, {own_, other_},
                                [&] {
                                  if (!confine_files(FileUse::kRead, {own_})) return kNoLandlock;
                                  return error_of_opening(other_ / "file", O_RDONLY);
                                }),
            EACCES);
}

}  // namespace
}  // namespace cas::base
