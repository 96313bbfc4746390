// SPDX-License-Identifier: BSD-3-Clause
#include "base/read_file.hpp"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include "base/os/descriptor.hpp"
#include "tests/support/temporary_folder.hpp"

namespace cas::base {
namespace {

TEST(ReadFile, GivesAllBytes) {
  test::TemporaryFolder folder;
  std::string bytes(200'000, 'x');
  bytes[7] = '\0';
  folder.write("bytes", bytes);
  folder.write("empty", "");
  EXPECT_EQ(read_file(folder.path() / "bytes"), bytes);
  EXPECT_EQ(read_file(folder.path() / "empty"), "");
}

TEST(ReadFile, GivesNothingOfWhatCannotBeRead) {
  test::TemporaryFolder folder;
  EXPECT_EQ(read_file(folder.path()), std::nullopt);
  EXPECT_EQ(read_file(folder.path() / "missing"), std::nullopt);
}

TEST(ReadFile, GivesNothingOfAProcessThatHasEnded) {
  const pid_t child = ::fork();
  if (child == 0) {
    ::pause();
    ::_exit(0);
  }
  // Opened while it runs, read when it has ended: then /proc answers ESRCH.
  const Descriptor open(
      ::open(("/proc/" + std::to_string(child) + "/stat").c_str(), O_RDONLY | O_CLOEXEC));
  ASSERT_TRUE(open);
  ::kill(child, SIGKILL);
  ::waitpid(child, nullptr, 0);
  EXPECT_EQ(read_file("/proc/self/fd/" + std::to_string(open.get())), std::nullopt);
}

}  // namespace
}  // namespace cas::base
