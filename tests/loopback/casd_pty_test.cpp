// SPDX-License-Identifier: BSD-3-Clause
// Whose pseudo-terminal it is: the real casd keeps off terminals that no emulator offers.
#include <fcntl.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <stdlib.h>
#include <sys/ioctl.h>
#include <sys/prctl.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <termios.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <chrono>
#include <memory>
#include <nlohmann/json.hpp>
#include <regex>
#include <string>

#include "base/os/descriptor.hpp"
#include "mavlink/common/heartbeat.hpp"
#include "mavlink/common/hil_sensor.hpp"
#include "mavlink_gen/runtime/codec.hpp"
#include "tests/base/config/scoped_environment.hpp"
#include "tests/loopback/running_casd.hpp"
#include "tests/support/paths.hpp"
#include "tests/support/pty_pair.hpp"
#include "tests/support/temporary_folder.hpp"
#include "tests/support/udp_peer.hpp"

namespace cas::test {
namespace {

using mavlink::common::HilSensor;
using nlohmann::json;

std::string program(const std::string& name) { return binary_dir() + "/bin/" + name; }

/// A foreign new terminal, as a terminal emulator makes it: it echoes, and no program holds a lock.
struct Terminal {
  Terminal() : master(::posix_openpt(O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC)) {
    std::array<char, 64> text{};
    if (::grantpt(master.get()) != 0 || ::unlockpt(master.get()) != 0 ||
        ::ptsname_r(master.get(), text.data(), text.size()) != 0) {
      throw std::runtime_error("no pseudo-terminal");
    }
    name = text.data();
    slave = base::Descriptor(::open(name.c_str(), O_RDWR | O_NOCTTY | O_CLOEXEC));
    ::tcgetattr(slave.get(), &settings);
  }
  /// Whether it got no byte and its settings are unchanged.
  bool untouched() const {
    termios now{};
    char byte = 0;
    const bool silent = ::read(master.get(), &byte, 1) < 0 && errno == EAGAIN;
    return silent && ::tcgetattr(slave.get(), &now) == 0 && now.c_lflag == settings.c_lflag &&
           now.c_iflag == settings.c_iflag && now.c_oflag == settings.c_oflag &&
           now.c_cflag == settings.c_cflag;
  }

  base::Descriptor master;
  base::Descriptor slave;
  std::string name;
  termios settings{};
};

/// A fresh terminal of this name, once the name is free. Nothing when another program was faster.
std::unique_ptr<Terminal> terminal_named(const std::string& name) {
  std::unique_ptr<Terminal> terminal;
  const bool found = wait_until(
      [&] {
        terminal = std::make_unique<Terminal>();
        return terminal->name == name;
      },
      std::chrono::seconds(2));
  return found ? std::move(terminal) : nullptr;
}

/// A shell in a terminal: a session leader whose controlling terminal it is.
class Session {
 public:
  explicit Session(const std::string& terminal) {
    std::array<int, 2> ready{};
    if (::pipe2(ready.data(), O_CLOEXEC) != 0) throw std::runtime_error("no pipe");
    leader_ = ::fork();
    if (leader_ == 0) {
      ::prctl(PR_SET_PDEATHSIG, SIGKILL);
      ::setsid();
      const int slave = ::open(terminal.c_str(), O_RDWR | O_NOCTTY);
      const bool taken = ::ioctl(slave, TIOCSCTTY, 0) == 0;
      if (::write(ready[1], taken ? "1" : "0", 1) == 1) ::pause();
      ::_exit(0);
    }
    char taken = 0;
    if (::read(ready[0], &taken, 1) != 1 || taken != '1') throw std::runtime_error("no session");
    ::close(ready[0]);
    ::close(ready[1]);
  }
  ~Session() {
    ::kill(leader_, SIGKILL);
    ::waitpid(leader_, nullptr, 0);
  }
  Session(const Session&) = delete;
  Session& operator=(const Session&) = delete;

  pid_t leader() const { return leader_; }

 private:
  pid_t leader_ = -1;
};

/// The real casd between a simulator and the device at a path.
class CasdPty : public testing::Test {
 protected:
  void start_casd(const std::string& device, const std::string& keys = "") {
    const auto topology =
        folder_.write("casd.yaml",
                      "schema: 1\ncommand_port: {port: 0, loopback_without_token: true}\nlinks:\n"
                      "  - {name: sim, type: udp, local: '127.0.0.1:0'}\n"
                      "  - {name: fcu, type: serial, queue: {hil_max_age_ms: 60000}, device: '" +
                          device + "'" + keys +
                          "}\n"
                          "routes:\n"
                          "  - {from: sim, to: fcu, allow: [HIL_SENSOR]}\n"
                          "  - {from: fcu, to: sim}\n");
    start_with(topology);
  }
  void start_with(const std::filesystem::path& topology) {
    casd_ =
        std::make_unique<RunningCasd>(std::vector<std::string>{kCasdProgram, topology.string()});
    sim_.set_remote(port_of(link("sim").at("endpoint")));
  }
  void start_emulator(std::vector<std::string> more = {}) {
    more.insert(more.begin(),
                {program("fcu_emulator"), source_dir() + "/config/fcu/iris_paper.yaml"});
    emulator_ = std::make_unique<ChildProcess>(more);
    if (!emulator_->wait_ready()) throw std::runtime_error(emulator_->output());
  }
  void kill_emulator() {
    emulator_->signal(SIGKILL);
    ASSERT_EQ(emulator_->wait_exit(), 128 + SIGKILL);
  }

  json link(const std::string& name) { return casd_->link(name); }
  bool is_up() { return link("fcu").at("state") == "up"; }
  std::string reason() { return link("fcu").at("endpoint"); }
  bool wait_up() {
    return wait_until([&] { return is_up(); });
  }
  /// Waits until the link is down for a reason with these words; the simulator goes on meanwhile.
  bool wait_refused(const std::string& words) {
    return wait_until([&] {
      send_sensors(1);
      return !is_up() && reason().find(words) != std::string::npos;
    });
  }
  void send_sensors(int count) {
    for (int i = 0; i < count; ++i) {
      sim_.send(simulator_(HilSensor{.time_usec = ++sent_}));
    }
  }
  /// Sends many HIL_SENSOR and waits until casd has had them all.
  bool flood() {
    for (int i = 0; i < 10; ++i) {
      send_sensors(50);
      if (!wait_until([&] { return link("sim").at("rx").at("packets") == sent_; })) return false;
    }
    return true;
  }
  std::string casctl(const std::string& verb) { return casd_->casctl({verb}).output; }

  TemporaryFolder folder_;
  UdpPeer sim_;
  mav::Encoder simulator_{{1, 200}};
  std::uint64_t sent_ = 0;
  std::unique_ptr<ChildProcess> emulator_;
  std::unique_ptr<RunningCasd> casd_;
};

TEST_F(CasdPty, AStrangersTerminalIsLeftAloneWhereAnEmulatorWasKilled) {
  const std::string device = folder_ / "fcu0";
  std::unique_ptr<Terminal> stranger;
  // Another program may take the number first: then once more.
  for (int round = 0; round < 10 && !stranger; ++round) {
    start_emulator({"--link", device});
    if (!casd_) start_casd(device);
    ASSERT_TRUE(wait_up()) << reason();
    ASSERT_TRUE(flood());
    const std::string name = std::filesystem::read_symlink(device);
    kill_emulator();
    ASSERT_EQ(std::filesystem::read_symlink(device), name) << "the symlink stays behind";
    stranger = terminal_named(name);
  }
  ASSERT_TRUE(stranger) << "the number did not come back";

  ASSERT_TRUE(wait_refused("is offered by no running program")) << reason();
  EXPECT_NE(reason().find(device + ": pseudo-terminal " + stranger->name), std::string::npos)
      << reason();
  ASSERT_TRUE(flood());
  EXPECT_TRUE(stranger->untouched());
  EXPECT_NE(casctl("links").find("is offered by no running program"), std::string::npos);
  const std::string doctor = casctl("doctor");
  EXPECT_NE(doctor.find("is offered by no running program"), std::string::npos) << doctor;
  EXPECT_NE(doctor.find("start the emulator"), std::string::npos) << doctor;

  // The next emulator takes the symlink over, and casd finds it.
  start_emulator({"--link", device});
  const base::RunTime begin = base::steady_now();
  ASSERT_TRUE(wait_up()) << reason();
  RecordProperty("found_us", static_cast<int>((base::steady_now() - begin).count() / 1000));
  ASSERT_TRUE(wait_until([&] { return link("fcu").at("rx").at("packets") > 0; }));
  EXPECT_TRUE(stranger->untouched());
}

TEST_F(CasdPty, AnEmulatorKilledAndStartedAnewIsFoundEachTime) {
  const std::string device = folder_ / "fcu0";
  start_casd(device);
  for (int round = 0; round < 3; ++round) {
    start_emulator({"--link", device});
    ASSERT_TRUE(wait_up()) << reason();
    kill_emulator();
    ASSERT_TRUE(wait_until([&] { return !is_up(); }));
  }
}

TEST_F(CasdPty, AChangedModeOfAnOfferedTerminalDoesNoHarm) {
  const std::string device = folder_ / "fcu0";
  start_emulator({"--link", device});
  ASSERT_EQ(::chmod(device.c_str(), 0660), 0);
  start_casd(device);
  ASSERT_TRUE(wait_up()) << reason();
}

TEST_F(CasdPty, ATerminalWithoutALockTakesConsent) {
  PtyPair line;
  start_casd(line.slave());
  ASSERT_TRUE(wait_refused("set unlocked_pty: true")) << reason();
  start_casd(line.slave(), ", unlocked_pty: true");
  ASSERT_TRUE(wait_up()) << reason();
  PacketStream heard;
  ASSERT_TRUE(wait_until([&] {
    send_sensors(1);
    line.read(heard);
    return heard.count(HilSensor::kId) > 0;
  }));
}

TEST_F(CasdPty, ASessionsTerminalIsRefusedWhateverIsSaid) {
  const Terminal terminal;
  auto session = std::make_unique<Session>(terminal.name);
  start_casd(terminal.name, ", unlocked_pty: true");
  const std::string process = "process " + std::to_string(session->leader());
  ASSERT_TRUE(wait_refused("is the terminal of")) << reason();
  EXPECT_NE(reason().find(process), std::string::npos) << reason();
  ASSERT_TRUE(flood());
  EXPECT_TRUE(terminal.untouched());
  session.reset();
  EXPECT_TRUE(wait_up()) << "the session has ended; " << reason();
}

TEST_F(CasdPty, EmulatorAndShippedTopologyMeetInTheRuntimeFolder) {
  const base::ScopedEnvironment runtime("CAS_RUNTIME_DIR", folder_.path().c_str());
  std::string text = TemporaryFolder::read(source_dir() + "/config/topologies/bench_pty.yaml");
  text = std::regex_replace(text, std::regex("(\\n +)port: 5790"),
                            "$1loopback_without_token: true$1port: 0");
  text = std::regex_replace(text, std::regex("local: 127\\.0\\.0\\.1:\\d+"), "local: 127.0.0.1:0");
  text = std::regex_replace(text, std::regex("remote: 127\\.0\\.0\\.1:\\d+"),
                            "remote: " + sim_.endpoint());
  start_emulator();
  start_with(folder_.write("casd.yaml", text));
  ASSERT_TRUE(wait_up()) << reason();
  EXPECT_EQ(reason(), (folder_ / "fcu0").string() + " 921600");
  EXPECT_TRUE(wait_until([&] { return casd_->call("casd.status").at("vehicles").size() == 1; }));
}

}  // namespace
}  // namespace cas::test
