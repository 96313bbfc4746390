// SPDX-License-Identifier: BSD-3-Clause
// Whole flights by hils, as a user starts them: hilsim, casd and a firmware as programs of their
// own.
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>

#include "casd/tlog/tlog_packets.hpp"
#include "mavlink/common/all.hpp"
#include "mavlink/common/table.hpp"
#include "mavlink_gen/runtime/codec.hpp"
#include "tests/firmware/shipped_text.hpp"
#include "tests/support/free_port.hpp"
#include "tests/support/paths.hpp"
#include "tests/support/temporary_folder.hpp"
#include "tests/support/vehicle_summary.hpp"

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

class FirmwareFlightOnASerialLine : public FirmwareFlight {
 protected:
  /// @param text  of the scenario, whose firmware is added
  int fly_hitl(const std::string& text) {
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
    return fly(text, world, topology);
  }

  static constexpr const char* kFirmware = "px4-hitl, '${CAS_FCU_TTY}'], on_serial_line: true";
};

TEST_F(FirmwareFlightOnASerialLine, Px4HitlTakesOffHoversAndLands) {
  EXPECT_EQ(fly_hitl(scenario("px4_hitl", kFirmware)), 0) << log();
}

TEST_F(FirmwareFlightOnASerialLine, Px4HitlFliesAfterEachFaultOfTheBenchHasHitItOnTheGround) {
  const std::string steps = R"(steps:
  - hold: {name: noisy, duration_s: 3}
  - hold: {name: unplugged, duration_s: 3}
  - hold: {name: restarted, duration_s: 3}
  - hold: {name: paused, duration_s: 3}
  - hold: {name: reloaded, duration_s: 3}
)";
  const std::string faults = R"(faults:
  - {name: noise, when: phase == noisy, line: {bit_error_rate: 0.0005, packet_loss: 0.2}, for_s: 1}
  - {name: unplug, when: phase == unplugged, unplug: fcu, for_s: 1}
  - {name: restart, when: phase == restarted, restart: casd, for_s: 1}
  - {name: pause, when: phase == paused, pause: hilsim, for_s: 1.5}
  - {name: reload, when: phase == reloaded, reload: casd, for_s: 1}
)";
  const std::string text = scenario("px4_hitl", kFirmware);
  ASSERT_EQ(fly_hitl(replaced(text, "steps:\n", steps) + faults), 0) << log();
  const nlohmann::json summary = vehicle_summary(folder_ / "out");
  ASSERT_EQ(summary.at("faults").size(), 5U) << summary.dump(2);
  for (const nlohmann::json& fault : summary.at("faults")) {
    EXPECT_FALSE(fault.contains("began")) << fault;
    EXPECT_TRUE(fault.at("end_s").is_number()) << fault;
  }
  EXPECT_TRUE(std::filesystem::exists(folder_ / "out/run/flight_1.tlog")) << "of the first casd";
  std::set<std::string> said;
  casd::for_each_tlog_packet(folder_ / "out/flight.tlog", mavlink::common::table(),
                             [&](std::uint64_t, const mav::PacketView& packet) {
                               const auto message =
                                   mav::decode<mavlink::common::Statustext>(packet);
                               if (message) said.insert(std::string(mav::text(message->text)));
                             });
  EXPECT_TRUE(said.contains("BARO #0 failed: TIMEOUT!\t")) << "the pause was felt";
}

/// The shipped flight with a line that loses everything for a while in hover.
std::string with_a_cut(const std::string& scenario, const char* for_s) {
  return scenario + "faults:\n  - {name: cut, when: phase == hold, line: " +
         "{packet_loss: 1}, for_s: " + for_s + "}\n";
}

TEST_F(FirmwareFlightOnASerialLine, Px4HitlFliesOnAfterALineThatWasCutFor50Ms) {
  EXPECT_EQ(fly_hitl(with_a_cut(scenario("px4_hitl", kFirmware), "0.05")), 0) << log();
  const nlohmann::json summary = vehicle_summary(folder_ / "out");
  ASSERT_EQ(summary.at("faults").size(), 1U);
  EXPECT_FALSE(summary.at("faults").at(0).contains("began"));
}

/// v1.16.1 goes into TERMINATION after a second without samples.
TEST_F(FirmwareFlightOnASerialLine, Px4HitlFallsAfterALineThatWasCutFor2S) {
  EXPECT_EQ(fly_hitl(with_a_cut(scenario("px4_hitl", kFirmware), "2")), 1) << log();
  bool terminated = false;
  casd::for_each_tlog_packet(
      folder_ / "out/flight.tlog", mavlink::common::table(),
      [&](std::uint64_t, const mav::PacketView& packet) {
        const auto beat = mav::decode<mavlink::common::Heartbeat>(packet);
        terminated |= beat && beat->system_status == mavlink::common::MavState::kFlightTermination;
      });
  EXPECT_TRUE(terminated);
  EXPECT_NE(content(folder_ / "out/summary.json").find("\"crash\""), std::string::npos) << log();
}

}  // namespace
}  // namespace cas::test
