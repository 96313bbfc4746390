// SPDX-License-Identifier: BSD-3-Clause
#include "hils/boards/board_lock.hpp"

#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <optional>
#include <string>
#include <thread>

#include "base/error.hpp"
#include "tests/support/temporary_folder.hpp"
#include "tests/support/wait_until.hpp"

namespace cas::hils {
namespace {

namespace fs = std::filesystem;

TEST(LockFolder, IsOneForAUserWhateverTheEnvironmentSays) {
  const test::TemporaryFolder runtime;
  ::setenv("CAS_RUNTIME_DIR", runtime.path().c_str(), 1);
  ::setenv("XDG_RUNTIME_DIR", runtime.path().c_str(), 1);
  EXPECT_EQ(lock_folder({}).string(), "/var/tmp/cas-boards-" + std::to_string(::getuid()));
  BoardList list;
  list.lock_folder = runtime / "locks";
  EXPECT_EQ(lock_folder(list).string(), (runtime / "locks").string());
  EXPECT_TRUE(fs::is_directory(runtime / "locks"));
}

TEST(LockFolder, IsTheUsersAlone) {
  const test::TemporaryFolder parent;
  const fs::path folder = own_lock_folder(parent.path());
  EXPECT_EQ(fs::status(folder).permissions(), fs::perms::owner_all);
  EXPECT_EQ(own_lock_folder(parent.path()).string(), folder.string());
  fs::permissions(folder, fs::perms(0755));
  EXPECT_THROW(own_lock_folder(parent.path()), base::ConfigError);
  fs::remove(folder);
  fs::create_directory_symlink(parent.path(), folder);
  EXPECT_THROW(own_lock_folder(parent.path()), base::ConfigError);
}

TEST(LockFolder, IsRefusedWhereOthersMayDeleteALock) {
  const test::TemporaryFolder parent;
  BoardList list;
  list.lock_folder = parent / "locks";
  fs::create_directory(list.lock_folder);
  fs::permissions(list.lock_folder, fs::perms(0770));
  EXPECT_THROW(lock_folder(list), base::ConfigError);
  EXPECT_EQ(fs::status(list.lock_folder).permissions(), fs::perms(0770)) << "it is not ours";
  fs::permissions(list.lock_folder, fs::perms(01770));
  EXPECT_NO_THROW(lock_folder(list));
}

TEST(BoardLock, IsForTheGroupAndWaitsForNoForeignFile) {
  const test::TemporaryFolder folder;
  const Board board{.name = "a", .serial = "SN1"};
  const fs::path file = lock_file(folder.path(), board);
  {
    const mode_t before = ::umask(077);
    const BoardLock lock(board, folder.path(), "first", std::nullopt);
    ::umask(before);
    EXPECT_EQ(fs::status(file).permissions(), fs::perms(0660));
  }
  ::unsetenv("CAS_BOARD_HOLDER");
  fs::remove(file);
  ASSERT_EQ(::mkfifo(file.c_str(), 0660), 0);
  EXPECT_FALSE(look_at_lock(board, folder.path()).held);
  EXPECT_THROW(BoardLock(board, folder.path(), "second", std::nullopt), base::ConfigError);
}

TEST(BoardLock, ClearsNothingAwayBehindASymlinkInThePlaceOfTheQueue) {
  const test::TemporaryFolder folder;
  const Board board{.name = "a", .serial = "SN1"};
  folder.write("theirs/file", "");
  fs::create_directory(folder / "locks");
  fs::path queue = lock_file(folder / "locks", board);
  queue.replace_extension(".queue");
  fs::create_directory_symlink(folder / "theirs", queue);
  EXPECT_EQ(look_at_lock(board, folder / "locks").waiting, 0U);
  EXPECT_TRUE(fs::exists(folder / "theirs/file"));
  fs::remove(queue);
  fs::create_directory(queue);
  folder.write("locks/" + queue.filename().string() + "/of_a_waiter_that_ended", "");
  look_at_lock(board, folder / "locks");
  EXPECT_TRUE(fs::is_empty(queue)) << "a ticket without a waiter is cleared away";
}

TEST(BoardLock, IsThatOfTheFileThatIsThereThoughOneWaitedForAnother) {
  const test::TemporaryFolder folder;
  const Board board{.name = "a", .serial = "SN1"};
  std::optional<BoardLock> first;
  first.emplace(board, folder.path(), "first", std::nullopt);
  ::unsetenv("CAS_BOARD_HOLDER");  // the second is no guest of the first
  std::optional<BoardLock> second;
  std::thread waiter(
      [&] { second.emplace(board, folder.path(), "second", std::chrono::minutes(5)); });
  EXPECT_TRUE(test::wait_until([&] { return look_at_lock(board, folder.path()).waiting == 1; }));
  fs::remove(lock_file(folder.path(), board));
  first.reset();
  waiter.join();
  const LockState state = look_at_lock(board, folder.path());
  ASSERT_TRUE(state.holder);
  EXPECT_EQ(state.holder->purpose, "second");
  ::unsetenv("CAS_BOARD_HOLDER");
}

}  // namespace
}  // namespace cas::hils
