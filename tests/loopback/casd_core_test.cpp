// SPDX-License-Identifier: BSD-3-Clause
// Link threads that seek their processor core, under the streams of a HIL loop in real time.
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <string>
#include <thread>
#include <vector>

#include "base/os/thread.hpp"
#include "tests/loopback/casd_fixture.hpp"

namespace cas::test {
namespace {

using namespace std::chrono_literals;  // NOLINT: periods

/// The processors that each of casd's link threads may run on, as the kernel words them.
std::vector<std::string> processors_of_link_threads() {
  std::vector<std::string> lists;
  for (const auto& task : std::filesystem::directory_iterator("/proc/self/task")) {
    std::ifstream name(task.path() / "comm");
    std::string line;
    if (!std::getline(name, line) || line.rfind("casd:", 0) != 0) continue;
    std::ifstream status(task.path() / "status");
    while (std::getline(status, line)) {
      if (line.rfind("Cpus_allowed_list:", 0) == 0) lists.push_back(line);
    }
  }
  return lists;
}

bool is_one_processor(const std::string& list) {
  return list.find_first_of(",-") == std::string::npos;
}

class CasdCore : public testing::Test {
 protected:
  void SetUp() override {
    if (base::allowed_cpus().size() < 2) GTEST_SKIP() << "one processor";
    if (!base::ThreadTimesReader().read()) GTEST_SKIP() << "no times of threads";
  }

  /// 500 HIL_SENSOR a second down, 500 HIL_CONTROLS up, until the condition holds or time is up.
  template <class Condition>
  bool stream_until(Condition&& condition, base::Duration at_most) {
    const auto begin = std::chrono::steady_clock::now();
    for (auto turn = begin; turn - begin < at_most; turn += 2ms) {
      std::this_thread::sleep_until(turn);
      ++sent;
      fixture.sim.send(fixture.from_sim(hil_sensor(sent)));
      fixture.fcu.write(fixture.from_fcu(hil_controls(sent)));
      fixture.collect();
      if (condition()) return true;
    }
    return false;
  }

  void expect_nothing_lost() {
    EXPECT_TRUE(fixture.collect_until([&] {
      return fixture.at_fcu.count(kHilSensor) == sent && fixture.at_sim.count(kHilControls) == sent;
    }));
  }

  CasdFixture fixture;
  std::uint64_t sent = 0;
};

TEST_F(CasdCore, ALinkThreadTriesItsProcessorsUnderAHilStream) {
  fixture.start(kHilTopology);
  EXPECT_TRUE(stream_until(
      [] {
        const std::vector<std::string> lists = processors_of_link_threads();
        return std::any_of(lists.begin(), lists.end(), is_one_processor);
      },
      20s));
  // On through trials and settling.
  stream_until([] { return false; }, 2s);
  expect_nothing_lost();
}

TEST_F(CasdCore, StaysOnAllProcessorsWithoutSeekCore) {
  fixture.start("seek_core: false\n" + std::string(kHilTopology));
  EXPECT_FALSE(stream_until(
      [] {
        const std::vector<std::string> lists = processors_of_link_threads();
        return std::any_of(lists.begin(), lists.end(), is_one_processor);
      },
      2s));
  expect_nothing_lost();
}

}  // namespace
}  // namespace cas::test
