// SPDX-License-Identifier: BSD-3-Clause
#include "hils/programs/supervisor.hpp"

#include <gtest/gtest.h>
#include <poll.h>
#include <signal.h>
#include <unistd.h>

#include <chrono>
#include <string>
#include <vector>

#include "base/error.hpp"
#include "hils/run/run_paths.hpp"
#include "tests/support/paths.hpp"
#include "tests/support/refusal.hpp"

namespace cas::hils {
namespace {

using std::chrono::seconds;

class SupervisorTest : public testing::Test {
 protected:
  ChildProcess::Options child(const std::string& name, const std::string& mode) const {
    return options(name, {cas::test::binary_dir() + "/tests/notify_child", mode});
  }
  ChildProcess::Options script(const std::string& name, const std::string& body) const {
    return options(name, {"/bin/sh", "-c", body});
  }
  ChildProcess::Options options(const std::string& name,
                                const std::vector<std::string>& arguments) const {
    return {.name = name,
            .arguments = arguments,
            .log_file = folder_.path() / (name + ".log"),
            .notify_socket = folder_.path() / (name + ".notify")};
  }

  RunDirectory folder_;
  Supervisor supervisor_;
};

TEST_F(SupervisorTest, WaitsForReadyAndEndsInGoodOrder) {
  ChildProcess& good = supervisor_.start(child("good", "wait"), seconds(20));
  EXPECT_TRUE(supervisor_.stop(good, seconds(20)));
  EXPECT_NO_THROW(supervisor_.check());
  EXPECT_EQ(supervisor_.cpu_s().size(), 1U);
}

TEST_F(SupervisorTest, KillsAProgramThatDoesNotEnd) {
  ChildProcess& deaf = supervisor_.start(child("deaf", "deaf"), seconds(20));
  EXPECT_FALSE(supervisor_.stop(deaf, std::chrono::milliseconds(100)));
}

TEST_F(SupervisorTest, EndsSeveralAtOnceAndNamesTheOneThatDoesNot) {
  ChildProcess& first = supervisor_.launch(child("first", "wait"));
  ChildProcess& second = supervisor_.launch(child("second", "wait"));
  ChildProcess& deaf = supervisor_.launch(child("deaf", "deaf"));
  for (const ChildProcess* launched : {&second, &first, &deaf}) {
    supervisor_.wait_ready(*launched, seconds(20));
  }
  EXPECT_EQ(supervisor_.stop({&first, &second}, seconds(20)), nullptr);
  EXPECT_EQ(supervisor_.cpu_s().size(), 2U);
  ChildProcess& third = supervisor_.start(child("third", "wait"), seconds(20));
  // Waited for in full, and long enough for the third to end on a loaded machine.
  EXPECT_EQ(supervisor_.stop({&third, &deaf}, seconds(5)), &deaf);
  EXPECT_NO_THROW(supervisor_.check()) << "each was expected to end";
}

TEST_F(SupervisorTest, ReportsAnEarlyDeathWithTheLastLines) {
  const auto stopped = test::thrown<RunStopped>(
      [&] { supervisor_.start(script("casd", "echo no such device >&2; exit 78"), seconds(20)); });
  ASSERT_TRUE(stopped);
  const std::string text = stopped->what();
  EXPECT_NE(text.find("casd ended with exit code 78"), std::string::npos) << text;
  EXPECT_NE(text.find("no such device"), std::string::npos) << text;
  EXPECT_FALSE(stopped->interrupted());
}

TEST_F(SupervisorTest, ReportsAProgramThatIsNotThere) {
  EXPECT_THROW(supervisor_.start(options("casd", {"/nonexistent/casd"}), seconds(20)), RunStopped);
}

TEST_F(SupervisorTest, ReportsAProgramThatNeverGetsReady) {
  const std::string text = test::refusal<RunStopped>(
      [&] { supervisor_.start(script("slow", "exec sleep 60"), std::chrono::milliseconds(200)); });
  EXPECT_NE(text.find("was not ready"), std::string::npos) << text;
}

TEST_F(SupervisorTest, ADeathDuringTheRunStopsTheWaiting) {
  try {  // either call may be the one that notices
    supervisor_.start(child("fcu", "crash"), seconds(20));
    supervisor_.wait(seconds(20));
    FAIL() << "no error";
  } catch (const RunStopped& stopped) {
    EXPECT_NE(std::string(stopped.what()).find("signal 9"), std::string::npos) << stopped.what();
  }
}

TEST_F(SupervisorTest, AnInterruptEndsEverything) {
  ChildProcess& casd = supervisor_.start(child("casd", "wait"), seconds(20));
  ::kill(::getpid(), SIGINT);
  EXPECT_TRUE(
      test::thrown<RunStopped>([&] { supervisor_.wait(seconds(20)); }).value().interrupted());
  supervisor_.stop(casd, seconds(20));  // returns once it is gone
  SUCCEED();
}

TEST_F(SupervisorTest, LeavesTheProgramsALastMomentWhereItIsToldTo) {
  ChildProcess& casd = supervisor_.start(child("casd", "wait"), seconds(20));
  supervisor_.linger(std::chrono::hours(1));
  ::kill(::getpid(), SIGINT);
  EXPECT_THROW(supervisor_.wait(seconds(20)), RunStopped);
  EXPECT_FALSE(casd.poll_exit());
  supervisor_.end_lingering();
  EXPECT_TRUE(supervisor_.stop(casd, seconds(20)));
}

TEST_F(SupervisorTest, LeavesTheProgramsNoMoreThanTheirLastMoment) {
  ChildProcess& casd = supervisor_.start(child("casd", "wait"), seconds(20));
  supervisor_.linger(std::chrono::milliseconds(50));
  ::kill(::getpid(), SIGINT);
  EXPECT_THROW(supervisor_.wait(seconds(20)), RunStopped);
  pollfd end{casd.pidfd(), POLLIN, 0};
  EXPECT_EQ(::poll(&end, 1, 20'000), 1);
}

TEST(FreePorts, AreDifferent) {
  const auto ports = free_udp_ports(3);
  EXPECT_NE(ports[0], ports[1]);
  EXPECT_NE(ports[1], ports[2]);
  EXPECT_NE(ports[0], 0);
}

}  // namespace
}  // namespace cas::hils
