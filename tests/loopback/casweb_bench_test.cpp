// SPDX-License-Identifier: BSD-3-Clause
// A page over casweb against the real hilsim, casd and fcu_emulator.
#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <cstring>
#include <deque>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <stop_token>
#include <string>
#include <thread>
#include <utility>

#include "base/rpc/client.hpp"
#include "base/rpc/token.hpp"
#include "mavlink_gen/runtime/sha256.hpp"
#include "tests/loopback/casweb_fixture.hpp"
#include "tests/loopback/emulator_fixture.hpp"
#include "tests/loopback/running_casd.hpp"
#include "tests/loopback/tcp_peer.hpp"
#include "tests/support/udp_peer.hpp"

namespace cas::test {
namespace {

using nlohmann::json;

bool is_program(const json& frame, const char* name, const char* state) {
  return frame.value("method", "") == "event.program" && frame["params"]["name"] == name &&
         frame["params"]["state"] == state;
}

class CaswebBench : public testing::Test {
 protected:
  void start_bench() {
    bench_.start();
    bench_.start_simulator();
    ASSERT_TRUE(bench_.hears_the_vehicle()) << bench_.output();
  }
  /// Waits until casweb has found a program.
  static bool finds(WebPage& page, const std::string& name) {
    return wait_until([&] {
      const json status = page.call("bench.status", json::object()).at("result");
      for (const json& program : status.at("programs")) {
        if (program.at("name") == name && program.at("state") == "up") return true;
      }
      return false;
    });
  }

  EmulatorFixture bench_;
};

TEST_F(CaswebBench, ShowsTheLoopAndPassesCommandsOn) {
  start_bench();
  CaswebFixture casweb(bench_.folder.path());
  auto page = casweb.open_page();
  ASSERT_TRUE(finds(*page, "casd"));
  ASSERT_TRUE(finds(*page, "hilsim"));

  const json scene = page->call("sim.scene", json::object()).at("result");
  ASSERT_EQ(scene.at("vehicles").size(), 1U);
  EXPECT_EQ(scene["vehicles"][0].at("rotors").size(), 4U);
  EXPECT_FALSE(scene["vehicles"][0].at("parts").empty());

  ASSERT_EQ(page->call("watch", {{"topics",
                                  {{"sim", 60},
                                   {"clouds", 5},
                                   {"links", 2},
                                   {"vehicle", 10},
                                   {"value", 10},
                                   {"loop", 1}}}})
                .at("result"),
            true);
  // The truth moves on in simulated time; a sample may come twice.
  double before = 0;
  ASSERT_TRUE(wait_until([&] {
    const auto motion = page->next("snap.sim");
    if (!motion) return false;
    page->ack("sim", *motion);
    EXPECT_EQ(motion->at("v")[0].at("rotors").size(), 4U);
    EXPECT_EQ(motion->at("v")[0].at("contact"), 1);
    const double last = std::exchange(before, motion->at("t_s").get<double>());
    EXPECT_GE(before, last);
    return last > 0 && before > last;
  }));
  // Both hops of both links, once both directions have been seen.
  EXPECT_TRUE(wait_until([&] {
    const auto links = page->next("snap.links");
    if (!links) return false;
    page->ack("links", *links);
    const json& hops = links->at("hops");
    return hops.size() == 4 && hops[0]["from"] == "sim" &&
           hops[0]["msgs"].value("HIL_SENSOR", 0.0) > 0 && hops[3]["from"] == "fcu" &&
           hops[3]["msgs"].value("HIL_CONTROLS", 0.0) > 0;
  }));
  const auto clouds = page->next("snap.clouds");
  ASSERT_TRUE(clouds);
  EXPECT_EQ(clouds->at("v"), json::array({json::array()})) << "a vehicle without a lidar";
  const auto vehicle = page->next("snap.vehicle");
  ASSERT_TRUE(vehicle);
  EXPECT_EQ(vehicle->at("vehicles")[0].at("state").at("system"), 1);

  // casd's answers, and its refusals, come as they are.
  EXPECT_EQ(page->call("vehicle.disarm", json::object()).at("result").at("vehicle"), 1);
  EXPECT_EQ(page->call("vehicle.land", {{"vehicle", 9}}).at("error").at("code"), -32002);
  EXPECT_TRUE(page->call("gain.get", {{"loop", "velocity"}}).at("result").contains("p"));
  EXPECT_EQ(page->call("sim.pause", json::object()).at("result").at("paused"), true);
  EXPECT_EQ(page->call("sim.resume", json::object()).at("result").at("paused"), false);
}

TEST_F(CaswebBench, SendsWatchedFieldsOnceEachInOrder) {
  bench_.start();
  ASSERT_TRUE(bench_.hears_the_vehicle());
  CaswebFixture casweb(bench_.folder.path());
  auto page = casweb.open_page();
  ASSERT_TRUE(finds(*page, "casd"));
  page->call("watch", {{"topics", {{"value", 10}}}});
  const json watch{{"link", "fcu"}, {"message", "HEARTBEAT"}, {"system", 1}, {"component", 1}};
  json fields = watch;
  fields["fields"] = {"type", "no such field"};
  const std::string key = page->call("message.watch", fields).at("result").at("key");
  int heard = 0;
  double last = -1e9;
  while (heard < 3) {
    const auto values = page->next("snap.value");
    ASSERT_TRUE(values);
    ASSERT_EQ(values->at("series")[0].at("key"), key);
    for (const json& sample : values->at("series")[0].at("samples")) {
      ++heard;
      ASSERT_EQ(sample.size(), 3U);
      EXPECT_GT(sample[0].get<double>(), last) << "each packet once, in order";
      last = sample[0];
      EXPECT_FALSE(sample[1].is_null());
      EXPECT_TRUE(sample[2].is_null());
    }
    page->ack("value", *values);
  }
  // The bounds of one page.
  fields["fields"] = std::vector<std::string>(25, "type");
  EXPECT_TRUE(page->call("message.watch", fields).contains("error"));
  EXPECT_EQ(page->call("message.unwatch", {{"key", key}}).at("result"), true);
}

TEST_F(CaswebBench, ASlowPageKeepsNobodyWaiting) {
  start_bench();
  CaswebFixture casweb(bench_.folder.path());
  auto slow = casweb.open_page();
  auto quick = casweb.open_page();
  ASSERT_TRUE(finds(*quick, "hilsim"));
  const json topics{{"topics", {{"sim", 60}}}};
  slow->call("watch", topics);
  ASSERT_TRUE(slow->next("snap.sim"));  // and never acknowledges it
  slow->call("watch", topics);          // nor does it get another one by asking again
  quick->call("watch", topics);
  std::uint64_t seq = 0;
  for (int i = 0; i < 30; ++i) {
    const auto motion = quick->next("snap.sim");
    ASSERT_TRUE(motion);
    EXPECT_GT(motion->at("seq").get<std::uint64_t>(), seq);
    seq = motion->at("seq");
    quick->ack("sim", *motion);
  }
  // Frames that the slow one did not take are dropped: the answer is the next frame.
  slow->call("bench.status", json::object());
  for (const json& frame : slow->kept()) EXPECT_NE(frame.at("method"), "snap.sim");
}

TEST_F(CaswebBench, SurvivesTheEndOfCasd) {
  bench_.start();
  CaswebFixture casweb(bench_.folder.path());
  auto page = casweb.open_page();
  ASSERT_TRUE(finds(*page, "casd"));
  bench_.kill_casd();
  const auto down = page->wait_for([](const json& frame) {
    return is_program(frame, "casd", "down") && frame["params"]["reason"] == "casd is gone";
  });
  ASSERT_TRUE(down);
  EXPECT_EQ(page->call("casd.status", json::object()).at("error").at("code"), -32000);
  bench_.start_casd(bench_.device(), 0);
  EXPECT_TRUE(page->wait_for([&](const json& frame) {
    return is_program(frame, "casd", "up") && frame["params"]["seq"] > down->at("params")["seq"];
  }));
  EXPECT_EQ(page->call("casd.status", json::object()).at("result").at("program"), "casd");
}

TEST(CaswebScene, HasTheMeshesOfTheWorldByTheirContent) {
  const TemporaryFolder folder;
  const std::string world =
      folder
          .write(
              "world.yaml",
              "schema: 1\nworld: " + cas::test::source_dir() +
                  "/config/worlds/village.sdf\ndecimal_year: 2026.5\npace: realtime\nvehicles:\n"
                  "  - name: iris0\n    vehicle: " +
                  cas::test::source_dir() +
                  "/config/vehicles/iris_paper.yaml\n    plugins: [{plugin: motor},"
                  " {plugin: rangefinder, rate_hz: 50, stddev_m: 0.001, min_m: 0.02, max_m: 40}]\n")
          .string();
  ChildProcess hilsim({cas::test::binary_dir() + "/bin/hilsim", world, "--control",
                       (folder / "hilsim.sock").string(), "--plugin-dir",
                       cas::test::binary_dir() + "/plugins"});
  ASSERT_TRUE(hilsim.wait_ready()) << hilsim.output();
  CaswebFixture casweb(folder.path());
  auto page = casweb.open_page();
  json scene;
  ASSERT_TRUE(wait_until([&] {
    scene = page->call("sim.scene", json::object()).value("result", json());
    return scene.is_object();
  }));
  EXPECT_EQ(scene["vehicles"][0]["rays"][0]["max_m"], 40);
  EXPECT_FALSE(scene["obstacles"].empty());
  std::string hash;
  for (const json& part : scene["world"]) {
    if (part["shape"] == "mesh") hash = part["mesh"].get<std::string>().substr(7);
  }
  const HttpAnswer mesh = http_request(casweb.port(), "GET", "/mesh/" + hash, casweb.host());
  ASSERT_EQ(mesh.status, 200);
  const auto* bytes = reinterpret_cast<const std::uint8_t*>(mesh.body.data());
  std::string digest;
  for (const std::uint8_t byte : mav::Sha256().update({bytes, mesh.body.size()}).finish()) {
    constexpr const char* kDigits = "0123456789abcdef";
    digest += {kDigits[byte >> 4U], kDigits[byte & 15U]};
  }
  EXPECT_EQ(digest, hash);
  std::uint32_t counts[2];
  std::memcpy(counts, bytes, sizeof counts);
  EXPECT_GT(counts[1], 0U);
  EXPECT_EQ(mesh.body.size(), 8 + 12 * (counts[0] + counts[1]));
  EXPECT_EQ(
      http_request(casweb.port(), "GET", "/mesh/" + std::string(64, '0'), casweb.host()).status,
      404);

  page->call("watch", {{"topics", {{"sim", 60}}}});
  EXPECT_TRUE(wait_until([&] {  // the beam points down from a vehicle on the ground
    const auto motion = page->next("snap.sim");
    if (!motion) return false;
    page->ack("sim", *motion);
    const json& rays = motion->at("v")[0].at("rays");
    return rays.size() == 1 && rays[0].is_number() && rays[0] < 0.5;
  }));
}

/// Strangers that connect to a port one after the other while this object lives. The newest stay.
class Flood {
 public:
  explicit Flood(std::uint16_t port)
      : thread_([this, port](const std::stop_token& stop) {
          std::deque<TcpPeer> strangers;
          while (!stop.stop_requested()) {
            strangers.emplace_back(port);
            ++connected_;
            if (strangers.size() > kMost) strangers.pop_front();
          }
        }) {}
  int connected() const { return connected_; }

 private:
  static constexpr std::size_t kMost = 300;  // more than casd has places
  std::atomic<int> connected_{0};
  std::jthread thread_;
};

TEST(CaswebFlooded, ServesThePageAndCasdTheClientWithTheToken) {
  const TemporaryFolder folder;
  const auto topology = folder.write(
      "casd.yaml", "schema: 1\ncommand_port: {port: 0, unix: '" + (folder / "casd.sock").string() +
                       "', token_file: '" + (folder / "casd.token").string() +
                       "'}\nlinks: [{name: a, type: udp, local: '127.0.0.1:0'}]\n");
  RunningCasd casd({kCasdProgram, topology.string()});
  const std::string address = casd.address();
  const json token{{"token", base::rpc::read_token(folder / "casd.token")}};
  CaswebFixture casweb(folder.path());

  base::rpc::Client client(address);
  ASSERT_EQ(client.call("authorise", token), true);
  const Flood flood(port_of(address));
  ASSERT_TRUE(wait_until([&] { return flood.connected() > 500; }));
  constexpr auto kPatienceOfAPerson = std::chrono::seconds(10);
  for (int i = 0; i < 20; ++i) {
    EXPECT_TRUE(
        client.call("casd.status", json::object(), kPatienceOfAPerson).contains("vehicles"));
  }
  // A new client of the flooded port; a stranger may take its place before it asks.
  EXPECT_TRUE(wait_until([&] {
    try {
      base::rpc::Client newcomer(address);
      return newcomer.call("authorise", token) == true &&
             newcomer.call("casd.status", json::object()).contains("vehicles");
    } catch (const std::runtime_error&) {
      return false;
    }
  }));
  EXPECT_EQ(http_request(casweb.port(), "GET", "/", casweb.host()).status, 200);
  auto page = casweb.open_page();
  EXPECT_TRUE(wait_until([&] {
    return page->call("link.list", json::object()).contains("result");
  })) << "casweb asks casd";
  const int before = flood.connected();
  EXPECT_TRUE(wait_until([&] { return flood.connected() > before; })) << "it was flooded all along";
}

}  // namespace
}  // namespace cas::test
