// SPDX-License-Identifier: BSD-3-Clause
#include "base/os/pty_lock.hpp"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <stdlib.h>
#include <sys/prctl.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <string>

#include "base/error.hpp"
#include "base/os/command_port.hpp"
#include "tests/support/refusal.hpp"
#include "tests/support/temporary_folder.hpp"

namespace cas::base {
namespace {

/// A fresh pseudo-terminal.
struct Pair {
  Pair() : master(::posix_openpt(O_RDWR | O_NOCTTY | O_CLOEXEC)) {
    std::array<char, 64> text{};
    if (::grantpt(master.get()) != 0 || ::unlockpt(master.get()) != 0 ||
        ::ptsname_r(master.get(), text.data(), text.size()) != 0) {
      throw std::runtime_error("no pseudo-terminal");
    }
    name = text.data();
    slave = Descriptor(::open(name.c_str(), O_RDWR | O_NOCTTY | O_CLOEXEC));
  }
  Descriptor master;
  Descriptor slave;
  std::string name;
};

class PtyLockTest : public testing::Test {
 protected:
  PtyOffer offer(const Pair& pair) const { return pty_offer(link_, pair.slave.get()); }

  cas::test::TemporaryFolder folder_;
  std::filesystem::path link_ = folder_ / "fcu0";
  Pair pair_;
};

TEST_F(PtyLockTest, OnlyAPseudoTerminalsSlaveHasAnIdentity) {
  EXPECT_TRUE(identify_pty(pair_.slave.get()));
  EXPECT_FALSE(identify_pty(Descriptor(::open("/dev/null", O_RDWR | O_CLOEXEC)).get()));
  EXPECT_FALSE(identify_pty(Descriptor(::open("/dev/ptmx", O_RDWR | O_CLOEXEC)).get()));
  EXPECT_FALSE(identify_pty(-1));
}

TEST_F(PtyLockTest, NamesOneTerminalAtATime) {
  EXPECT_EQ(offer(pair_), PtyOffer::kNone);
  PtyLock lock(link_);
  EXPECT_EQ(offer(pair_), PtyOffer::kOther) << "it names none yet";
  lock.name(pair_.slave.get());
  EXPECT_EQ(offer(pair_), PtyOffer::kThis);
  const Pair other;
  EXPECT_EQ(offer(other), PtyOffer::kOther);
  lock.name(other.slave.get());
  EXPECT_EQ(offer(other), PtyOffer::kThis);
  EXPECT_EQ(offer(pair_), PtyOffer::kOther);
  lock.clear();
  EXPECT_EQ(offer(other), PtyOffer::kOther);
}

TEST_F(PtyLockTest, IsGoneWithItsOwner) {
  {
    PtyLock lock(link_);
    lock.name(pair_.slave.get());
  }
  EXPECT_EQ(offer(pair_), PtyOffer::kNone);
  EXPECT_FALSE(std::filesystem::exists(link_.string() + ".lock"));
}

TEST_F(PtyLockTest, AKilledOwnersRecordStaysAndCountsForNothing) {
  std::array<int, 2> ready{};
  ASSERT_EQ(::pipe(ready.data()), 0);
  const pid_t owner = ::fork();
  if (owner == 0) {
    ::prctl(PR_SET_PDEATHSIG, SIGKILL);
    PtyLock lock(link_);
    lock.name(pair_.slave.get());
    if (::write(ready[1], "1", 1) == 1) ::pause();
    ::_exit(1);
  }
  char byte = 0;
  ASSERT_EQ(::read(ready[0], &byte, 1), 1);
  EXPECT_EQ(offer(pair_), PtyOffer::kThis);
  EXPECT_THROW(PtyLock{link_}, ConfigError);
  ::kill(owner, SIGKILL);
  ::waitpid(owner, nullptr, 0);
  EXPECT_TRUE(std::filesystem::exists(link_.string() + ".lock"));
  EXPECT_EQ(offer(pair_), PtyOffer::kNone);
  PtyLock next(link_);  // the next owner takes the stale lock
  EXPECT_EQ(offer(pair_), PtyOffer::kOther);
  ::close(ready[0]);
  ::close(ready[1]);
}

TEST_F(PtyLockTest, ASecondOwnerIsRefusedInWords) {
  const PtyLock lock(link_);
  // Of the kind after which a program may start again: it may be free then.
  EXPECT_EQ(cas::test::refusal<CommandPortError>([&] { const PtyLock second(link_); }),
            link_.string() + " is offered by another program");
}

TEST_F(PtyLockTest, AChangedModeIsNamedAnew) {
  PtyLock lock(link_);
  lock.name(pair_.slave.get());
  struct stat before {};
  struct stat after {};
  ASSERT_EQ(::fstat(pair_.slave.get(), &before), 0);
  do {  // the kernel's clock of files has ticks of some milliseconds
    ASSERT_EQ(::fchmod(pair_.slave.get(), 0660), 0);
    ASSERT_EQ(::fstat(pair_.slave.get(), &after), 0);
  } while (before.st_ctim.tv_nsec == after.st_ctim.tv_nsec);
  EXPECT_EQ(offer(pair_), PtyOffer::kOther);
  lock.name(pair_.slave.get());
  EXPECT_EQ(offer(pair_), PtyOffer::kThis);
}

TEST_F(PtyLockTest, IsFoundBesideAnySymlinkOnTheWay) {
  PtyLock lock(link_);
  lock.name(pair_.slave.get());
  std::filesystem::create_symlink(pair_.name, link_);
  std::filesystem::create_symlink("fcu0", folder_ / "near");
  std::filesystem::create_symlink(folder_ / "near", folder_ / "far");
  EXPECT_EQ(pty_offer(folder_ / "far", pair_.slave.get()), PtyOffer::kThis);
  std::filesystem::create_symlink("round", folder_ / "round");
  EXPECT_EQ(pty_offer(folder_ / "round", pair_.slave.get()), PtyOffer::kNone);
}

TEST_F(PtyLockTest, ASymlinkInItsPlaceIsNotFollowed) {
  const auto victim = folder_.write("victim", "precious");
  std::filesystem::create_symlink(victim, link_.string() + ".lock");
  EXPECT_THROW(PtyLock{link_}, ConfigError);
  EXPECT_EQ(std::filesystem::file_size(victim), 8U);
}

}  // namespace
}  // namespace cas::base
