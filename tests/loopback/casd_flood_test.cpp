// SPDX-License-Identifier: BSD-3-Clause
// One link is flooded while the HIL loop runs on others.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <string>
#include <thread>
#include <vector>

#include "tests/loopback/casd_fixture.hpp"

namespace cas::test {
namespace {

/// The HIL loop, and a station that may set parameters.
std::string with_station() {
  std::string yaml = std::string(kHilTopology) + "  - {from: gcs, to: fcu, allow: [PARAM_SET]}\n";
  return yaml.insert(yaml.find("routes:"),
                     "  - {name: gcs, type: udp_server, local: \"127.0.0.1:0\"}\n");
}

bool has_thread(const std::string& name) {
  for (const auto& task : std::filesystem::directory_iterator("/proc/self/task")) {
    std::ifstream file(task.path() / "comm");
    std::string line;
    if (std::getline(file, line) && line == name) return true;
  }
  return false;
}

/// Sends one datagram of many heartbeats as fast as it can, as long as it lives.
class Flood {
 public:
  explicit Flood(std::uint16_t port)
      : thread_([this, port](const std::stop_token& stop) { run(stop, port); }) {}

 private:
  void run(const std::stop_token& stop, std::uint16_t port) {
    UdpPeer peer;
    peer.set_remote(port);
    mav::Encoder encoder{{255, 190}};
    std::vector<std::uint8_t> datagram;
    for (int i = 0; i < 40; ++i) {
      const auto packet = encoder(mavlink::common::Heartbeat{});
      datagram.insert(datagram.end(), packet.begin(), packet.end());
    }
    while (!stop.stop_requested()) peer.send(datagram);
  }

  std::jthread thread_;
};

TEST(CasdFlood, TheFloodedLinkGetsAThreadAndTheHilLoopLosesNothing) {
  CasdFixture fixture(with_station());
  EXPECT_TRUE(has_thread("casd:links"));
  EXPECT_FALSE(has_thread("casd:gcs"));
  std::uint64_t sent = 0;
  const auto exchange = [&] {
    ++sent;
    fixture.sim.send(fixture.from_sim(hil_sensor(sent)));
    fixture.fcu.write(fixture.from_fcu(hil_controls(sent)));
    return fixture.collect_until([&] {
      return fixture.at_fcu.count(kHilSensor) == sent && fixture.at_sim.count(kHilControls) == sent;
    });
  };
  {
    const Flood flood(fixture.port("gcs"));
    ASSERT_TRUE(wait_until([&] { return exchange() && has_thread("casd:gcs"); }));
    for (int i = 0; i < 200; ++i) ASSERT_TRUE(exchange()) << i;
  }
  EXPECT_GT(fixture.status("gcs").rx.packets, 1000U);
  // The link is served as before wherever it is: a station's parameter arrives.
  UdpPeer station;
  station.set_remote(fixture.port("gcs"));
  mav::Encoder from_station{{254, 190}};
  station.send(from_station(mavlink::common::ParamSet{}));
  EXPECT_TRUE(fixture.collect_until(
      [&] { return fixture.at_fcu.count(mavlink::common::ParamSet::kId) == 1; }));
  EXPECT_TRUE(exchange());
}

TEST(CasdFlood, AFloodedLinkCanBeTakenOutOfTheTopology) {
  CasdFixture fixture(with_station());
  const Flood flood(fixture.port("gcs"));
  ASSERT_TRUE(wait_until([] { return has_thread("casd:gcs"); }));
  fixture.links().reload(fixture.parse(kHilTopology));
  EXPECT_TRUE(wait_until([] { return !has_thread("casd:gcs"); }));
  fixture.sim.send(fixture.from_sim(hil_sensor(1)));
  fixture.fcu.write(fixture.from_fcu(hil_controls(1)));
  EXPECT_TRUE(fixture.collect_until([&] {
    return fixture.at_fcu.count(kHilSensor) == 1 && fixture.at_sim.count(kHilControls) == 1;
  }));
}

TEST(CasdFlood, ALinkWithSchedulingOfItsOwnHasAThreadFromTheStart) {
  CasdFixture fixture;
  std::string yaml = with_station();
  const std::string type = "type: udp_server, ";
  fixture.start(yaml.insert(yaml.find(type) + type.size(), "scheduling: {cpus: [0]}, "));
  EXPECT_TRUE(has_thread("casd:gcs"));
  EXPECT_TRUE(has_thread("casd:links"));
}

}  // namespace
}  // namespace cas::test
