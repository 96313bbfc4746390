// SPDX-License-Identifier: BSD-3-Clause
// Whole flights by hils, as a user starts them: hilsim, casd and a firmware as programs of their
// own.
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <cstdlib>
#include <fstream>
#include <sstream>

#include "tests/firmware/shipped_text.hpp"
#include "tests/support/free_port.hpp"
#include "tests/support/paths.hpp"
#include "tests/support/temporary_folder.hpp"

namespace cas::test {
namespace {

/// A shipped scenario with its world and topology at free ports, flown by the scripted firmware.
class FirmwareFlight : public testing::Test {
 protected:
  int fly(const std::string& scenario_text, const std::string& world_text,
          const std::string& topology_text) {
    folder_.write("world.yaml", with_whole_paths(world_text));
    folder_.write("topology.yaml", with_whole_paths(topology_text));
    const auto scenario = folder_.write("scenario.yaml", scenario_text);
    const std::string command = cas::test::binary_dir() + "/bin/hils run " + scenario.string() +
                                " --out " + (folder_ / "out").string() + " > " +
                                (folder_ / "log").string() + " 2>&1";
    const int status = std::system(command.c_str());
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  }

  /// The shipped scenario with its own files and firmware left out.
  std::string scenario(const std::string& name, const std::string& firmware) {
    const std::string text = content(kConfig / "scenarios" / (name + ".yaml"));
    std::string kept;
    bool in_firmware = false;
    std::istringstream lines(text);
    for (std::string line; std::getline(lines, line);) {
      if (line.starts_with("world:")) line = "world: world.yaml";
      if (line.starts_with("topology:")) line = "topology: topology.yaml";
      if (line.starts_with("firmware:")) in_firmware = true;
      if (line.starts_with("steps:")) in_firmware = false;
      if (line.find("duration_s: 20") != std::string::npos) {
        line = "  - hold: {duration_s: 4, measure: true}";
      }
      if (!in_firmware) kept += line + "\n";
    }
    return kept + "firmware: {command: [\"" + cas::test::binary_dir() +
           "/tests/scripted_firmware\", " + firmware + "}\n";
  }

  std::string log() const { return content(folder_ / "log"); }

  TemporaryFolder folder_;
};

TEST_F(FirmwareFlight, Px4SitlOverTcp) {
  const Px4SitlPorts ports;
  const int code = fly(scenario("px4_sitl", "px4-sitl, " + ports.arguments() + "]"),
                       px4_sitl_world(ports), px4_sitl_topology(ports));
  EXPECT_EQ(code, 0) << log();
}

TEST_F(FirmwareFlight, ArdupilotOverUdp) {
  const std::string json = std::to_string(free_port());
  const std::string here = std::to_string(free_port());
  const int code = fly(scenario("ardupilot", "ardupilot, '" + json + "', '" + here + "']"),
                       replaced(content(kConfig / "worlds/ardupilot.yaml"),
                                "# local: 127.0.0.1:9002", "local: 127.0.0.1:" + json + "  #"),
                       replaced(replaced(content(kConfig / "topologies/ardupilot_sitl.yaml"),
                                         "local: 127.0.0.1:14550", "local: 127.0.0.1:" + here),
                                "local: 127.0.0.1:14551", "local: 127.0.0.1:0"));
  EXPECT_EQ(code, 0) << log();
}

TEST_F(FirmwareFlight, Px4HitlOnASerialLine) {
  const std::string sim = std::to_string(free_port());
  const std::string casd = std::to_string(free_port());
  const std::string gcs = std::to_string(free_port());
  std::string world = content(kConfig / "worlds/px4_hitl.yaml");
  world = replaced(replaced(world, "local: 127.0.0.1:14560", "local: 127.0.0.1:" + sim),
                   "remote: 127.0.0.1:14561", "remote: 127.0.0.1:" + casd);
  std::string topology = content(kConfig / "topologies/pixhawk_usb.yaml");
  topology = replaced(topology, "local: 127.0.0.1:14561, remote: 127.0.0.1:14560",
                      "local: 127.0.0.1:" + casd + ", remote: 127.0.0.1:" + sim);
  topology = replaced(topology, "remote: 127.0.0.1:14550", "remote: 127.0.0.1:" + gcs);
  const int code = fly(scenario("px4_hitl", "px4-hitl, '${CAS_FCU_TTY}'], on_serial_line: true"),
                       world, topology);
  EXPECT_EQ(code, 0) << log();
}

}  // namespace
}  // namespace cas::test
