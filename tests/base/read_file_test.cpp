// SPDX-License-Identifier: BSD-3-Clause
#include "base/read_file.hpp"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include "base/os/descriptor.hpp"
#include "tests/support/refusal.hpp"
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

std::string refusal(const std::filesystem::path& file, std::size_t most_bytes = 100) {
  return test::refusal([&] { read_foreign_file(file, "mesh", most_bytes); });
}

TEST(ReadForeignFile, GivesAllBytesUpToItsBound) {
  test::TemporaryFolder folder;
  folder.write("whole", std::string(100, 'x'));
  folder.write("larger", std::string(101, 'x'));
  EXPECT_EQ(read_foreign_file(folder.path() / "whole", "mesh", 100), std::string(100, 'x'));
  EXPECT_EQ(refusal(folder.path() / "larger"), (folder.path() / "larger").string() +
                                                   ": mesh is larger than the 100 bytes that are "
                                                   "read");
}

TEST(ReadForeignFile, RefusesWhatIsNoRegularFile) {
  test::TemporaryFolder folder;
  const std::filesystem::path fifo = folder.path() / "fifo";
  ASSERT_EQ(::mkfifo(fifo.c_str(), 0600), 0);
  EXPECT_EQ(refusal(fifo), fifo.string() + ": mesh is no regular file");  // and does not wait
  EXPECT_EQ(refusal("/dev/zero"), "/dev/zero: mesh is no regular file");
  EXPECT_EQ(refusal(folder.path()), folder.path().string() + ": mesh is a folder, not a file");
  EXPECT_EQ(refusal("/nowhere"), "/nowhere: mesh cannot be read");
}

}  // namespace
}  // namespace cas::base
