// SPDX-License-Identifier: BSD-3-Clause
// A run of hils is watched: casctl finds its casd, and a ground station joins.
#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>

#include <algorithm>
#include <array>
#include <csignal>
#include <filesystem>
#include <functional>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <regex>
#include <string>
#include <vector>

#include "base/os/descriptor.hpp"
#include "mavlink/common/all.hpp"
#include "mavlink_gen/runtime/codec.hpp"
#include "tests/firmware/shipped_text.hpp"
#include "tests/loopback/web_page.hpp"
#include "tests/support/ended_with.hpp"
#include "tests/support/free_port.hpp"
#include "tests/support/packet_stream.hpp"
#include "tests/support/paths.hpp"
#include "tests/support/scenario_text.hpp"
#include "tests/support/temporary_folder.hpp"
#include "tests/support/udp_peer.hpp"
#include "tests/support/vehicle_summary.hpp"
#include "tests/support/wait_until.hpp"

namespace cas::test {
namespace {

namespace fs = std::filesystem;
namespace mv = mavlink::common;

constexpr int kExitUsage = 2;
constexpr int kExitInterrupted = 130;

/// Rests on the ground for this time, by default longer than any test: the caller ends it.
std::string long_look(int seconds = 3600) {
  return scenario_text(
      paper_quadrotor(),
      "[hold: {duration_s: " + std::to_string(seconds) +
          "}, arm, takeoff: {altitude_m: 2}, hold: {duration_s: 1, measure: true}, land]");
}

sockaddr* generic(sockaddr_in& address) { return reinterpret_cast<sockaddr*>(&address); }

/// QGroundControl, as far as a vehicle sees it: it answers the last sender.
class Station {
 public:
  Station() : fd_(::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0)) {
    sockaddr_in local = loopback(0);
    socklen_t size = sizeof local;
    EXPECT_EQ(::bind(fd_.get(), generic(local), size), 0);
    EXPECT_EQ(::getsockname(fd_.get(), generic(local), &size), 0);
    port_ = ntohs(local.sin_port);
  }
  std::uint16_t port() const { return port_; }
  void send_to(std::uint16_t port) { peer_ = loopback(port); }

  /// Sends a HEARTBEAT, requests the vehicle's parameters, and reads all waiting packets.
  void speak_and_hear() {
    mv::Heartbeat heartbeat{.type = mv::MavType::kGcs, .autopilot = mv::MavAutopilot::kInvalid};
    mv::ParamRequestList request{.target_system = 1, .target_component = 1};
    if (peer_.sin_port != 0) {
      send(encode_(heartbeat));
      if (!heard(mv::ParamValue::kId)) send(encode_(request));
    }
    std::array<std::uint8_t, 2048> buffer;
    socklen_t size = sizeof peer_;
    ssize_t count = 0;
    while ((count = ::recvfrom(fd_.get(), buffer.data(), buffer.size(), 0, generic(peer_), &size)) >
           0) {
      stream_.feed(std::span(buffer).first(static_cast<std::size_t>(count)));
    }
  }
  /// Whether the vehicle's autopilot has said this.
  bool heard(std::uint32_t message) {
    for (const PacketStream::Packet& packet : stream_.packets()) {
      if (packet.message_id == message && packet.source == mav::Source{1, 1}) return true;
    }
    return false;
  }
  bool meets_the_vehicle() {
    return wait_until([this] {
      speak_and_hear();
      return heard(mv::Heartbeat::kId) && heard(mv::ParamValue::kId);
    });
  }

 private:
  static sockaddr_in loopback(std::uint16_t port) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    address.sin_port = htons(port);
    return address;
  }
  void send(std::span<const std::uint8_t> bytes) {
    ::sendto(fd_.get(), bytes.data(), bytes.size(), 0, generic(peer_), sizeof peer_);
  }

  base::Descriptor fd_;
  std::uint16_t port_ = 0;
  sockaddr_in peer_{};
  mav::Encoder encode_{{255, 190}};
  PacketStream stream_;
};

/// Programs in a session of their own, with a runtime folder of their own.
class HilsWatch : public testing::Test {
 protected:
  std::vector<std::string> in_session(const std::string& program,
                                      const std::vector<std::string>& arguments) const {
    std::vector<std::string> command{"/usr/bin/env",
                                     "-u",
                                     "CASD_ADDRESS",
                                     "-u",
                                     "CASD_TOKEN_FILE",
                                     "CAS_RUNTIME_DIR=" + (session_.path() / "cas").string(),
                                     binary_dir() + "/bin/" + program};
    command.insert(command.end(), arguments.begin(), arguments.end());
    return command;
  }
  std::unique_ptr<ChildProcess> hils(const std::string& endpoint) const {
    return std::make_unique<ChildProcess>(
        in_session("hils", {"run", folder_.write("long.yaml", long_look()).string(), "--gcs",
                            endpoint, "--out", folder_ / "out"}));
  }
  /// The line with the command to watch a run; empty if none comes. Checks that its casctl exists,
  /// and replaces it by "casctl".
  static std::string watch_line(const ChildProcess& hils) {
    std::string line;
    wait_until([&] {
      const std::string text = hils.output();
      const std::size_t begin = text.find("Watch it: ");
      const std::size_t end = text.find('\n', begin);
      if (begin == std::string::npos || end == std::string::npos) return false;
      line = text.substr(begin, end - begin);
      return true;
    });
    if (line.empty()) return line;
    constexpr std::size_t kProgram = sizeof "Watch it: " - 1;
    const std::string program = line.substr(0, line.find(' ', kProgram)).substr(kProgram);
    if (program != "casctl") {
      EXPECT_TRUE(program.ends_with("/casctl") && fs::exists(program)) << line;
    }
    return line.replace(kProgram, program.size(), "casctl");
  }
  std::unique_ptr<ChildProcess> casd() const {
    const fs::path topology =
        folder_.write("bench.yaml",
                      "schema: 1\ncommand_port: {port: 0}\nlinks:\n  - {name: a, type: udp, local: "
                      "'127.0.0.1:0'}\n");
    return std::make_unique<ChildProcess>(in_session("casd", {topology.string()}));
  }
  Ended casctl(const std::vector<std::string>& arguments) const {
    return ChildProcess(in_session("casctl", arguments)).end();
  }
  static void end(ChildProcess& hils) {
    hils.signal(SIGINT);
    EXPECT_EQ(hils.wait_exit(), kExitInterrupted) << hils.output();
  }

  TemporaryFolder folder_;
  TemporaryFolder session_;
};

TEST_F(HilsWatch, CasctlFindsARunAndAGroundStationJoinsIt) {
  Station station;
  const auto run = hils("udp:" + std::to_string(station.port()));
  EXPECT_EQ(watch_line(*run), "Watch it: casctl monitor; a ground station at 127.0.0.1:" +
                                  std::to_string(station.port()) + " is sent to over UDP")
      << run->output();
  EXPECT_TRUE(station.meets_the_vehicle()) << run->output();

  const Ended status = casctl({"--json", "status"});
  EXPECT_EQ(status.code, 0) << status.output;
  EXPECT_EQ(nlohmann::json::parse(status.output)["name"], "hop");

  const auto other = casd();
  ASSERT_TRUE(other->wait_ready().has_value()) << other->output();
  const Ended listed = casctl({"status"});
  EXPECT_THAT(listed, EndedWith(kExitUsage, "2 casds run"));
  EXPECT_TRUE(std::regex_search(listed.output, std::regex("hop +1 +20"))) << listed.output;
  end(*run);
  EXPECT_EQ(casctl({"status"}).code, 0) << "the run's casd is gone";
}

TEST_F(HilsWatch, ARunBesideAnotherCasdNamesItsAddress) {
  const auto other = casd();
  ASSERT_TRUE(other->wait_ready().has_value()) << other->output();
  const std::uint16_t port = free_port();
  const auto run = hils("udp_server:" + std::to_string(port));
  const std::string line = watch_line(*run);
  const std::string begin = "Watch it: casctl --address ";
  const std::string rest =
      " monitor; a ground station joins at 127.0.0.1:" + std::to_string(port) + " over UDP";
  ASSERT_TRUE(line.starts_with(begin) && line.ends_with(rest)) << run->output();
  const std::string address = line.substr(begin.size(), line.size() - begin.size() - rest.size());
  const Ended status = casctl({"--address", address, "--json", "status"});
  EXPECT_EQ(status.code, 0) << status.output;
  EXPECT_EQ(nlohmann::json::parse(status.output)["name"], "hop");

  EXPECT_NE(casctl({"status"}).output.find(address + " "), std::string::npos) << "as listed";

  Station station;
  station.send_to(port);
  EXPECT_TRUE(station.meets_the_vehicle()) << run->output();
  end(*run);
}

/// The page of a run, and the file with its address.
struct OpenPage {
  std::unique_ptr<WebPage> page;  ///< null if none opened
  fs::path address_file;
};

/// Opens the page whose address a run with --web tells.
OpenPage open_page(const ChildProcess& run) {
  std::smatch told;
  std::string text;
  const std::regex line(
      "Page: (http://127\\.0\\.0\\.1:([0-9]+)/) \\(the address with its token is in (.*)\\)\n");
  if (!wait_until([&] { return std::regex_search(text = run.output(), told, line); })) {
    ADD_FAILURE() << run.output();
    return {};
  }
  EXPECT_EQ(text.find("#k="), std::string::npos) << "what is no terminal is told no token";
  OpenPage open{nullptr, told[3].str()};
  EXPECT_EQ(fs::status(open.address_file).permissions(),
            fs::perms::owner_read | fs::perms::owner_write);
  const std::string address = TemporaryFolder::read(open.address_file);
  const std::string begin = told[1].str() + "#k=";
  EXPECT_TRUE(address.starts_with(begin)) << address;
  auto page = std::make_unique<WebPage>(static_cast<std::uint16_t>(std::stoi(told[2])));
  const std::string token = address.substr(begin.size(), address.size() - begin.size() - 1);
  EXPECT_TRUE(page->hello(token).contains("result"));
  open.page = std::move(page);
  return open;
}

/// Takes snapshots of a topic until one is as it should be.
std::optional<nlohmann::json> snapshot(WebPage& page, const std::string& topic,
                                       const std::function<bool(const nlohmann::json&)>& wanted) {
  std::optional<nlohmann::json> found;
  wait_until([&] {
    found = page.next("snap." + topic);
    if (found) page.ack(topic, *found);
    return !found || wanted(*found);
  });
  return found;
}

TEST_F(HilsWatch, APageShowsTheRunAtTheAddressInTheFileThatItNames) {
  const std::string limits = "limits: {lost: 0, rms: {x_m: 5}}\n";
  ChildProcess run(
      in_session("hils", {"run", folder_.write("short.yaml", long_look(3) + limits).string(),
                          "--web", "--out", folder_ / "out"}));
  const OpenPage open = open_page(run);
  ASSERT_TRUE(open.page);
  WebPage& page = *open.page;
  EXPECT_FALSE(fs::exists(session_.path() / "cas" / "casweb.token")) << "it ends with the run";
  EXPECT_TRUE(wait_until([&] {
    return page.call("sim.scene", nlohmann::json::object()).contains("result") &&
           page.call("casd.status", nlohmann::json::object()).contains("result");
  })) << page.call("bench.status", nlohmann::json::object());

  // Actions of a person: a pause, and a fault that is too short to hurt.
  EXPECT_TRUE(page.call("sim.pause", nlohmann::json::object()).contains("result"));
  EXPECT_TRUE(page.call("sim.resume", nlohmann::json::object()).contains("result"));
  const nlohmann::json fault{{"name", "no fix"}, {"drop", "gps"}, {"for_s", 0.05}};
  nlohmann::json answer;
  EXPECT_TRUE(wait_until([&] {
    answer = page.call("fault.inject", fault);
    return answer.contains("result");
  })) << answer;
  for (const auto& wrong :
       {nlohmann::json{{"drop", "gps"}},
        {{"drop", "gps"}, {"for_s", 99}},
        {{"gust", {{"amplitude_m_s", {3, 0, 0}}, {"length_m", 5}}}, {"for_s", 1}},
        {{"restart", "casd"}, {"for_s", 1}}}) {
    EXPECT_TRUE(page.call("fault.inject", wrong).contains("error")) << wrong;
  }
  const auto began = page.next("event.fault");
  ASSERT_TRUE(began);
  EXPECT_EQ(began->at("name"), "no fix");

  page.call("watch", {{"topics", {{"ref", 20}, {"verdict", 2}}}});
  const auto reference =
      snapshot(page, "ref", [](const auto& snap) { return snap.at("v")[0].is_object(); });
  ASSERT_TRUE(reference);
  EXPECT_NEAR(reference->at("v")[0].at("p_W")[2].template get<double>(), 2, 0.3) << *reference;
  const auto so_far = snapshot(page, "verdict", [](const auto& snap) {
    const auto& checks = snap.at("vehicles")[0].at("checks");
    return std::ranges::any_of(checks, [](const auto& each) { return each["value"].is_number(); });
  });
  ASSERT_TRUE(so_far);
  EXPECT_EQ(so_far->at("state"), "running");
  EXPECT_GE(so_far->at("vehicles")[0].at("checks").size(), 4U) << "packets, too, without a value";
  EXPECT_GE(so_far->at("touched").size(), 3U) << *so_far;
  const auto verdict = page.next("event.verdict");
  ASSERT_TRUE(verdict) << run.output();
  EXPECT_NE(verdict->at("state"), "running");
  EXPECT_FALSE(verdict->at("touched").empty());
  EXPECT_TRUE(run.wait_exit()) << run.output();
  EXPECT_FALSE(fs::exists(open.address_file));

  const nlohmann::json summary = vehicle_summary(folder_ / "out");
  EXPECT_EQ(summary.at("from_outside"), true);
  const std::string acts = summary.at("acts").dump();
  for (const char* act : {"sim.pause", "sim.resume", "fault.inject"}) {
    EXPECT_NE(acts.find(act), std::string::npos) << act << " in " << acts;
  }
  EXPECT_EQ(summary.at("faults").at(0).at("name"), "no fix") << summary.at("faults");
}

/// The scripted PX4 flies as in the shipped scenarios of stock firmware, at twice real time.
TEST_F(HilsWatch, APageAndAGroundStationSeeStockFirmwareToo) {
  const Px4SitlPorts ports;
  folder_.write("world.yaml",
                with_whole_paths(replaced(px4_sitl_world(ports), "\nspeed: 1\n", "\nspeed: 2\n")));
  folder_.write("topology.yaml", with_whole_paths(px4_sitl_topology(ports)));
  const fs::path scenario = folder_.write("stock.yaml", R"(schema: 1
name: stock
world: world.yaml
topology: topology.yaml
not_hil: true
steps:
  - arm: {timeout_s: 100}
  - takeoff: {altitude_m: 2, timeout_s: 100}
  - hold: {duration_s: 4, measure: true}
  - land: {timeout_s: 100}
  - disarm: {timeout_s: 50}
firmware:
  command: [')" + binary_dir() + "/tests/scripted_firmware', px4-sitl, " +
                                                            ports.arguments() + ", obedient]\n");
  Station station;
  ChildProcess run(
      in_session("hils", {"run", scenario.string(), "--web", "--gcs",
                          "udp:" + std::to_string(station.port()), "--out", folder_ / "out"}));
  const OpenPage open = open_page(run);
  ASSERT_TRUE(open.page);
  EXPECT_TRUE(wait_until([&] {
    return open.page->call("sim.scene", nlohmann::json::object()).contains("result");
  })) << run.output();
  EXPECT_TRUE(wait_until([&] {
    station.speak_and_hear();
    return station.heard(mv::Heartbeat::kId) && station.heard(mv::LocalPositionNed::kId);
  })) << run.output();
  open.page->call("watch", {{"topics", {{"ref", 20}, {"verdict", 2}}}});
  const auto reference =
      snapshot(*open.page, "ref", [](const auto& snap) { return snap.at("v")[0].is_object(); });
  ASSERT_TRUE(reference) << run.output();
  EXPECT_NEAR(reference->at("v")[0].at("p_W")[2].template get<double>(), 2, 0.3) << *reference;
  const auto verdict = open.page->next("event.verdict");
  ASSERT_TRUE(verdict) << run.output();
  EXPECT_NE(verdict->at("state"), "running");
  EXPECT_EQ(run.wait_exit(), 0) << run.output();
}

TEST_F(HilsWatch, RefusesAPortThatAnotherProgramHas) {
  const Station station;
  const auto run = hils("udp_server:" + std::to_string(station.port()));
  EXPECT_EQ(run->wait_exit(), kExitUsage);
  EXPECT_NE(run->output().find("cannot be opened; does another program have this port?"),
            std::string::npos)
      << run->output();
}

TEST_F(HilsWatch, ARunInWhichSomebodyTunesSaysSo) {
  const ChildProcess run(in_session(
      "hils", {"run", folder_.write("s.yaml", long_look(8)).string(), "--out", folder_ / "out"}));
  ASSERT_FALSE(watch_line(run).empty()) << run.output();
  Ended set{1, ""};
  EXPECT_TRUE(wait_until([&] {
    set = casctl({"setgain", "velocity", "--p", "1.2"});
    return set.code == 0;
  })) << set.output;
  EXPECT_TRUE(std::regex_search(set.output, std::regex("velocity: P ([0-9.]+ -> )?1.2,")))
      << set.output;
  // Whether the machine is quick enough for a verdict is no matter here.
  ASSERT_TRUE(wait_until([&] { return run.output().find("Results: ") != std::string::npos; },
                         std::chrono::seconds(120)))
      << run.output();
  const nlohmann::json summary = vehicle_summary(folder_ / "out");
  EXPECT_EQ(summary.at("from_outside"), true);
  ASSERT_EQ(summary.at("changes").size(), 1U) << summary.at("changes");
  const nlohmann::json& change = summary.at("changes").at(0);
  EXPECT_EQ(change.at("loop"), "velocity P");
  EXPECT_EQ(change.at("parameter"), "MPC_XY_VEL_P_ACC");
  EXPECT_FLOAT_EQ(change.at("new").get<float>(), 1.2F);
  EXPECT_TRUE(change.at("old").is_number()) << change;
  EXPECT_NE(change.at("by").get<std::string>().find("casd's command port ("), std::string::npos);
  EXPECT_NE(run.output().find("Changed in flight\n"), std::string::npos) << run.output();
}

}  // namespace
}  // namespace cas::test
