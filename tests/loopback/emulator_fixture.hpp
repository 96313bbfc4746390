// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <gtest/gtest.h>

#include <csignal>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "tests/support/child_process.hpp"
#include "tests/support/paths.hpp"
#include "tests/support/temporary_folder.hpp"
#include "tests/support/wait_until.hpp"

namespace cas::test {

/// The shipped programs around a pseudo-terminal: fcu_emulator, casd and, where asked for, hilsim.
class EmulatorFixture {
 public:
  /// Starts controller and daemon. `line` is the controller's, `baud` casd's setting for it.
  void start(const std::string& line = "{preset: ideal}", int baud = 0) {
    const std::string fcu =
        folder
            .write("fcu.yaml", "schema: 1\nvehicle: " + cas::test::source_dir() +
                                   "/config/vehicles/iris_paper.yaml\nline: " + line + "\n")
            .string();
    fcu_ = run({"fcu_emulator", fcu, "--link", device()});
    start_casd(device(), baud);
  }
  /// Starts the daemon alone, on a device that may not be there.
  void start_casd(const std::string& device, int baud) {
    const std::string topology =
        folder
            .write("casd.yaml",
                   "schema: 1\n"
                   "command_port: {unix: '" +
                       socket() +
                       "', port: 0, loopback_without_token: true}\n"
                       "log: {folder: '" +
                       folder.path().string() +
                       "'}\n"
                       "gains: " +
                       cas::test::source_dir() +
                       "/config/gains.yaml\n"
                       "links:\n"
                       "  - {name: sim, type: udp, local: '127.0.0.1:0'}\n"
                       "  - {name: fcu, type: serial, device: '" +
                       device + "', baud: " + std::to_string(baud) +
                       "}\n"
                       "routes:\n"
                       "  - {from: sim, to: fcu, allow: [HEARTBEAT, HIL_SENSOR, HIL_GPS]}\n"
                       "  - {from: fcu, to: sim, allow: [HEARTBEAT, HIL_CONTROLS]}\n")
            .string();
    casd_ = run({"casd", topology});
  }
  /// Starts the simulator against link `sim`, in real time.
  void start_simulator() {
    const std::string links = casctl({"links"}).output;
    const std::size_t at = links.find("127.0.0.1:");
    const std::string port = links.substr(at, links.find(' ', at) - at);
    const std::string world =
        folder
            .write("world.yaml",
                   "schema: 1\n"
                   "world: {gravity_m_s2: 9.80665, ground: true}\n"
                   "home: {lat_deg: 47.397742, lon_deg: 8.545594, alt_m: 488}\n"
                   "decimal_year: 2026.5\n"
                   "pace: realtime\n"
                   "vehicles:\n"
                   "  - name: iris0\n"
                   "    vehicle: " +
                       cas::test::source_dir() +
                       "/config/vehicles/iris_paper.yaml\n"
                       "    plugins: [{plugin: motor}, {plugin: imu}, {plugin: gps},"
                       " {plugin: magnetometer}, {plugin: barometer},"
                       " {plugin: mavlink_interface, transport: udp,"
                       " local: '127.0.0.1:0', remote: '" +
                       port + "'}]\n")
            .string();
    hilsim_ = run({"hilsim", world, "--control", control(), "--plugin-dir",
                   cas::test::binary_dir() + "/plugins"});
  }

  /// Runs the real casctl.
  Ended casctl(std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), {cas::test::binary_dir() + "/bin/casctl", "--address",
                                         "unix:" + socket(), "--timeout", "30"});
    return ChildProcess(arguments).end(std::chrono::seconds(60));
  }
  /// Waits until casd has heard the vehicle.
  bool hears_the_vehicle() {
    return wait_until([this] {
      return casctl({"status"}).output.find("heartbeat") == std::string::npos &&
             casctl({"status"}).output.find("PX4") != std::string::npos;
    });
  }

  void kill_controller() { fcu_->signal(SIGKILL); }
  void kill_casd() {
    casd_->signal(SIGKILL);
    EXPECT_TRUE(casd_->wait_exit());
  }

  std::string device() const { return (folder / "fcu0").string(); }
  std::string socket() const { return (folder / "casd.sock").string(); }
  std::string control() const { return (folder / "hilsim.sock").string(); }
  std::string output() const { return casd_->output() + fcu_->output(); }

  TemporaryFolder folder;

 private:
  std::unique_ptr<ChildProcess> run(std::vector<std::string> command) {
    command[0] = cas::test::binary_dir() + "/bin/" + command[0];
    auto child = std::make_unique<ChildProcess>(command);
    EXPECT_TRUE(child->wait_ready()) << child->output();
    return child;
  }

  std::unique_ptr<ChildProcess> fcu_;
  std::unique_ptr<ChildProcess> casd_;
  std::unique_ptr<ChildProcess> hilsim_;
};

}  // namespace cas::test
