// SPDX-License-Identifier: BSD-3-Clause
#include "casd/transport/pty_admission.hpp"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <sys/stat.h>
#include <sys/sysmacros.h>
#include <unistd.h>

#include "base/os/descriptor.hpp"
#include "tests/support/pty_pair.hpp"
#include "tests/support/temporary_folder.hpp"

namespace cas::casd {
namespace {

using cas::test::PtyPair;
using cas::test::TemporaryFolder;
using testing::HasSubstr;

/// Substitute for /proc.
class PtyAdmission : public testing::Test {
 protected:
  void process(int id, const std::string& name, long long terminal) {
    proc_.write(std::to_string(id) + "/stat", std::to_string(id) + " (" + name + ") S 1 " +
                                                  std::to_string(id) + " " + std::to_string(id) +
                                                  " " + std::to_string(terminal) + " -1 4194560");
  }
  std::string refusal(const PtyPair& pair, const std::string& device, bool unlocked) {
    const base::Descriptor slave(::open(pair.slave().c_str(), O_RDWR | O_NOCTTY | O_CLOEXEC));
    return pty_refusal(slave.get(), device, unlocked, proc_.path()).value_or("");
  }
  static long long number_of(const PtyPair& pair) {
    struct stat status {};
    ::stat(pair.slave().c_str(), &status);
    const unsigned low = minor(status.st_rdev);
    return (low & 0xFFU) | major(status.st_rdev) << 8U | (low & ~0xFFU) << 12U;
  }

  TemporaryFolder proc_;
  TemporaryFolder folder_;
};

TEST_F(PtyAdmission, FindsTheProcessWhoseTerminalItIs) {
  process(1, "init", 0);
  process(77, "a (b) c) S 9", 34'817);  // /dev/pts/1
  proc_.write("self/stat", "nonsense");
  proc_.write("90/stat", "90 (cut");
  const auto user = find_terminal_user(makedev(136, 1), proc_.path());
  ASSERT_TRUE(user);
  EXPECT_EQ(user->process, 77);
  EXPECT_EQ(user->program, "a (b) c) S 9");
  EXPECT_FALSE(find_terminal_user(makedev(136, 2), proc_.path()));
}

TEST_F(PtyAdmission, KnowsTerminalsBeyondTheFirst256) {
  process(5, "bash", (300 & 0xFF) | 136 << 8 | (300 & ~0xFF) << 12);
  EXPECT_TRUE(find_terminal_user(makedev(136, 300), proc_.path()));
  EXPECT_FALSE(find_terminal_user(makedev(136, 44), proc_.path()));
}

TEST_F(PtyAdmission, AnOfferedTerminalIsTaken) {
  process(1, "init", 0);
  const std::string device = folder_ / "fcu0";
  const PtyPair pair(device);
  EXPECT_EQ(refusal(pair, device, false), "");
  EXPECT_EQ(refusal(pair, device, true), "");
  EXPECT_NE(refusal(pair, pair.slave(), false), "") << "its own name has no lock";
}

TEST_F(PtyAdmission, WhatNobodyOffersIsRefusedUnlessSaidSo) {
  process(1, "init", 0);
  const PtyPair pair;
  const std::string why = refusal(pair, "/x/fcu0", false);
  EXPECT_EQ(why.rfind("/x/fcu0: pseudo-terminal " + pair.slave() + " is offered by no running", 0),
            0U)
      << why;
  EXPECT_THAT(why, HasSubstr("unlocked_pty: true"));
  EXPECT_EQ(refusal(pair, "/x/fcu0", true), "");
}

TEST_F(PtyAdmission, ASessionsTerminalIsNeverTaken) {
  process(1, "init", 0);
  const PtyPair pair;
  process(4711, "bash", number_of(pair));
  EXPECT_THAT(refusal(pair, "/x/fcu0", true), HasSubstr("is the terminal of bash, process 4711"));
}

TEST_F(PtyAdmission, AnotherTerminalThanTheOfferedOneIsRefusedWhateverIsSaid) {
  process(1, "init", 0);
  const std::string device = folder_ / "fcu0";
  const PtyPair offered(device);
  const PtyPair stranger;
  for (const bool unlocked : {false, true}) {
    EXPECT_THAT(refusal(stranger, device, unlocked), HasSubstr("is not the one"));
  }
}

TEST_F(PtyAdmission, WhereProcessesAreHiddenOnlyALockCounts) {
  const PtyPair pair;
  EXPECT_THAT(refusal(pair, "/x/fcu0", true), HasSubstr("/proc hides"));
  const std::string device = folder_ / "fcu0";
  const PtyPair offered(device);
  EXPECT_EQ(refusal(offered, device, false), "");
}

}  // namespace
}  // namespace cas::casd
