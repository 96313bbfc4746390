// SPDX-License-Identifier: BSD-3-Clause
// casd as its service runs it: killed, restarted and reloaded under the unit's own times, with the
// HIL streams going on.
#include <gtest/gtest.h>
#include <signal.h>

#include <algorithm>
#include <filesystem>

#include "base/rpc/client.hpp"
#include "tests/loopback/casd_fixture.hpp"
#include "tests/loopback/running_casd.hpp"
#include "tests/support/free_port.hpp"
#include "tests/support/paths.hpp"
#include "tests/support/supervisor.hpp"

namespace cas::test {
namespace {

using State = Supervisor::State;

UnitFile shipped_unit() {
  return UnitFile::load(cas::test::source_dir() + "/config/systemd/casd.service");
}

std::uint64_t micros(base::RunTime time) {
  return static_cast<std::uint64_t>(
      std::chrono::duration_cast<std::chrono::microseconds>(time.time_since_epoch()).count());
}

/// casd under its unit between a simulator and a controller's line.
class CasdService : public testing::Test {
 protected:
  void write_topology(const std::string& command_port = "{port: 0}") {
    std::string yaml = "command_port: " + command_port + "\n" + kHilTopology;
    const std::string any = "127.0.0.1:0";
    yaml.replace(yaml.find(any), any.size(), "127.0.0.1:" + std::to_string(port));
    topology = fixture.folder.write("casd.yaml", fixture.expand(yaml));
    fixture.sim.set_remote(port);
  }
  std::map<std::string, std::string> words() const {
    return {{"/usr/bin/casd", kCasdProgram}, {"/etc/cas/casd.yaml", topology}};
  }
  /// Streams HIL_SENSOR, stamped with the time of sending, until one that was sent after `moment`
  /// has reached the controller.
  bool reaches_the_controller_after(base::RunTime moment) {
    return wait_until([&] {
      fixture.sim.send(fixture.from_sim(hil_sensor(micros(base::steady_now()))));
      fixture.collect();
      const auto seen = numbers(fixture.at_fcu, kHilSensor);
      return !seen.empty() && seen.back() > micros(moment);
    });
  }
  void expect_nothing_old() {
    const auto seen = numbers(fixture.at_fcu, kHilSensor);
    EXPECT_TRUE(std::is_sorted(seen.begin(), seen.end())) << "an older packet came late";
  }

  CasdFixture fixture;
  std::uint16_t port = free_port();
  std::string topology;
};

TEST_F(CasdService, IsBackAfterBeingKilledAndSendsNothingOld) {
  write_topology();
  Supervisor service(shipped_unit(), words());
  ASSERT_TRUE(service.wait_ready()) << service.output();
  ASSERT_TRUE(reaches_the_controller_after(base::steady_now()));
  for (int round = 1; round <= 5; ++round) {
    const base::RunTime killed = service.signal(SIGKILL);
    ASSERT_TRUE(reaches_the_controller_after(killed)) << service.output();
    ASSERT_TRUE(service.wait_ready()) << service.output();
    EXPECT_EQ(service.starts(), round + 1);
  }
  expect_nothing_old();
}

TEST_F(CasdService, RestartAndReloadKeepTheStreamsGoing) {
  write_topology();
  Supervisor service(shipped_unit(), words());
  ASSERT_TRUE(service.wait_ready()) << service.output();
  service.restart();
  ASSERT_TRUE(reaches_the_controller_after(base::steady_now())) << service.output();
  ASSERT_TRUE(service.wait_ready()) << service.output();
  EXPECT_EQ(service.starts(), 2);

  service.reload();
  ASSERT_TRUE(service.prints("topology reloaded")) << service.output();
  ASSERT_TRUE(reaches_the_controller_after(base::steady_now()));
  EXPECT_EQ(service.starts(), 2) << "a reload is no restart";
  expect_nothing_old();
}

/// Without descriptors casd serves no new client, but it flies on, and feeds its watchdog.
TEST_F(CasdService, LivesWithoutDescriptors) {
  write_topology("{port: 0, unix: $DIR/casd.sock}");
  UnitFile unit = shipped_unit();
  unit.settings["ExecStart"] = {"/usr/bin/prlimit --nofile=40:40 " + unit.value("ExecStart")};
  Supervisor service(unit, words());
  ASSERT_TRUE(service.wait_ready()) << service.output();
  std::vector<std::unique_ptr<base::rpc::Client>> clients;
  for (int i = 0; i < 60; ++i) {
    clients.push_back(
        std::make_unique<base::rpc::Client>("unix:" + (fixture.folder / "casd.sock").string()));
  }
  ASSERT_TRUE(service.prints("Too many open files")) << service.output();
  const int feeds = service.feeds();
  EXPECT_TRUE(wait_until([&] { return service.feeds() >= feeds + 2; })) << service.output();
  EXPECT_TRUE(reaches_the_controller_after(base::steady_now()));
  EXPECT_EQ(service.starts(), 1) << service.output();
}

/// One link's thread hangs in the kernel; all others have their turns.
TEST_F(CasdService, IsReplacedWhenTheThreadOfOneLinkHangs) {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  GTEST_SKIP() << "sanitizers want to be the first library";
#endif
  const auto hang = fixture.folder / "hang";
  topology = fixture.folder.write(
      "casd.yaml",
      fixture.expand("schema: 1\ncommand_port: {port: 0}\nlinks:\n"
                     "  - {name: a, type: udp, local: '127.0.0.1:0'}\n"
                     "  - {name: b, type: serial, device: '$DIR/board', unlocked_pty: true}\n"));
  UnitFile unit = shipped_unit();
  unit.settings["ExecStart"] = {"/usr/bin/env LD_PRELOAD=" + binary_dir() +
                                "/tests/hanging_open.so CAS_TEST_HANG=" + hang.string() +
                                " CAS_TEST_HANG_AT=/board " + unit.value("ExecStart")};
  Supervisor service(unit, words());
  ASSERT_TRUE(service.wait_ready()) << service.output();
  const int feeds = service.feeds();
  ASSERT_TRUE(wait_until([&] { return service.feeds() >= feeds + 2; })) << service.output();
  EXPECT_EQ(service.output().find("a link's thread hangs"), std::string::npos);
  fixture.folder.write("hang", "");
  ASSERT_TRUE(wait_until([&] { return std::filesystem::exists(hang.string() + ".reached"); }));
  EXPECT_TRUE(service.prints("a link's thread hangs")) << service.output();
  std::filesystem::remove(hang);
}

TEST_F(CasdService, AWrongConfigurationIsNotTriedAgain) {
  write_topology("{port: none}");
  Supervisor service(shipped_unit(), words());
  ASSERT_TRUE(wait_until([&] { return service.state() == State::kFailed; })) << service.output();
  EXPECT_EQ(service.starts(), 1) << service.output();
}

TEST_F(CasdService, APortThatIsTakenIsTriedUntilItIsFree) {
  write_topology();
  Supervisor first(shipped_unit(), words());
  const auto status = first.wait_ready();
  ASSERT_TRUE(status) << first.output();
  const std::uint16_t taken = port_of(word_after(*status, "command_port"));

  port = free_port();
  write_topology("{port: " + std::to_string(taken) + "}");
  UnitFile patient = shipped_unit();
  patient.settings["StartLimitIntervalSec"] = {"0"};  // a loaded machine may take longer
  Supervisor second(patient, words());
  ASSERT_TRUE(wait_until([&] { return second.starts() >= 3; })) << second.output();
  first.signal(SIGTERM);
  ASSERT_TRUE(second.wait_ready()) << second.output();
}

}  // namespace
}  // namespace cas::test
