// SPDX-License-Identifier: BSD-3-Clause
// The program hilsim as a process: readiness, control socket, signals, files, refusals.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>

#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>

#include "base/rpc/client.hpp"
#include "libsim/core/rays/ray_scene.hpp"
#include "mavlink/common/landing_target.hpp"
#include "mavlink_gen/runtime/codec.hpp"
#include "tests/libsim/support/sim_files.hpp"
#include "tests/support/child_process.hpp"
#include "tests/support/paths.hpp"
#include "tests/support/temporary_folder.hpp"
#include "tests/support/udp_peer.hpp"

namespace cas::sim {
namespace {

using base::rpc::Client;
using base::rpc::Json;
using cas::test::ChildProcess;
using cas::test::wait_until;
using testing::HasSubstr;

const std::string kHilsim = cas::test::binary_dir() + "/bin/hilsim";

class Hilsim : public testing::Test {
 protected:
  std::string write(const std::string& pace, const std::string& plugins = "[]",
                    const std::string& more = "") {
    return folder_
        .write("sim.yaml",
               "schema: 1\nworld: {gravity_m_s2: 9.80665, ground: true}\n"
               "home: {lat_deg: 47.4, lon_deg: 8.5, alt_m: 488}\n"
               "decimal_year: 2026.5\npace: " +
                   pace + "\n" + more + "vehicles:\n" + test::vehicle("iris0", "{z_m: 1}", plugins))
        .string();
  }
  std::vector<std::string> command(const std::string& config, std::vector<std::string> more = {}) {
    std::vector<std::string> all{kHilsim,        config,
                                 "--control",    socket(),
                                 "--stats",      stats(),
                                 "--output",     (folder_.path() / "out").string(),
                                 "--plugin-dir", test::kFakePluginDir.string()};
    all.insert(all.end(), more.begin(), more.end());
    return all;
  }
  static std::string rangefinder(const std::string& more) {
    return "{plugin: rangefinder, rate_hz: 50, stddev_m: 0.001, min_m: 0.01, max_m: 40" + more +
           "}";
  }
  std::string socket() const { return (folder_.path() / "control").string(); }
  std::string stats() const { return (folder_.path() / "stats.json").string(); }
  Json read_stats() const { return Json::parse(std::ifstream(stats())); }

  cas::test::TemporaryFolder folder_;
};

TEST_F(Hilsim, TellsWhatThereIsAndHowItMoves) {
  ChildProcess hilsim(command(write("realtime", "[{plugin: fake_counter}]"), {"--paused"}));
  ASSERT_TRUE(hilsim.wait_ready()) << hilsim.output();
  Client client("unix:" + socket());

  const Json scene = client.call("sim.scene", nullptr);
  ASSERT_EQ(scene.at("vehicles").size(), 1U);
  const Json& vehicle = scene["vehicles"][0];
  EXPECT_EQ(vehicle.at("rotors").size(), 4U);
  EXPECT_EQ(vehicle.at("parts").at(0).at("shape"), "box") << "what collides is what is drawn";
  EXPECT_EQ(scene.at("world").at(0).at("shape"), "plane");
  EXPECT_EQ(client.call("sim.scene", nullptr).at("hash"), scene.at("hash"));
  EXPECT_THROW(client.call("sim.mesh", {{"hash", "none"}}), base::rpc::CallError);

  EXPECT_EQ(client.call("sim.watch", nullptr).at("t_s"), 0);
  client.call("sim.step", {{"n", 250}});
  Json motion;
  EXPECT_TRUE(wait_until([&] {  // a sample is shared for a sixtieth of a second
    motion = client.call("sim.watch", nullptr);
    return motion.at("t_s") == 0.25;
  }));
  EXPECT_TRUE(motion.at("paused"));
  EXPECT_LT(motion.at("v")[0].at("vel")[2].get<double>(), -2.0) << "it falls";
}

TEST_F(Hilsim, TellsOfABeamWhoseAxesAreOneNumber) {
  ChildProcess hilsim(
      command(write("realtime", "[{plugin: motor}, " + rangefinder(", position_B_m: 0.1") + "]"),
              {"--paused"}));
  ASSERT_TRUE(hilsim.wait_ready()) << hilsim.output();
  Client client("unix:" + socket());
  const Json rays = client.call("sim.scene", nullptr).at("vehicles")[0].at("rays");
  ASSERT_EQ(rays.size(), 1U);
  EXPECT_EQ(rays[0].at("p_B"), Json({0.1, 0.1, 0.1}));
}

TEST_F(Hilsim, MotionBeginsAnewWithAReset) {
  ChildProcess hilsim(
      command(write("realtime", "[{plugin: motor}, " + rangefinder("") + "]"), {"--paused"}));
  ASSERT_TRUE(hilsim.wait_ready()) << hilsim.output();
  Client client("unix:" + socket());
  const Json blank = client.call("sim.watch", nullptr).at("v")[0];
  EXPECT_EQ(blank.at("rotors"), Json({0, 0, 0, 0}));
  EXPECT_EQ(blank.at("rays"), Json::array({nullptr}));
  client.call("sim.step", {{"n", 250}});
  EXPECT_TRUE(wait_until(
      [&] { return client.call("sim.watch", nullptr).at("v")[0].at("rays")[0].is_number(); }));
  client.call("sim.reset", nullptr);
  EXPECT_TRUE(wait_until([&] { return client.call("sim.watch", nullptr).at("v")[0] == blank; }));
}

TEST_F(Hilsim, TellsWhatLidarsSeeUntilAReset) {
  ChildProcess hilsim(
      command(write("realtime",
                    "[{plugin: motor}, {plugin: lidar, pattern: ../lidars/vlp16.yaml, rate_hz: 10, "
                    "min_m: 0.1, max_m: 50}]"),
              {"--paused"}));
  ASSERT_TRUE(hilsim.wait_ready()) << hilsim.output();
  Client client("unix:" + socket());
  EXPECT_EQ(client.call("sim.clouds", nullptr).at("v"), Json::array({Json::array()}));
  client.call("sim.step", {{"n", 250}});
  const Json places = client.call("sim.clouds", nullptr).at("v")[0];
  ASSERT_GT(places.size(), 3 * 300U);
  ASSERT_LE(places.size(), 3 * 1500U);
  for (std::size_t i = 2; i < places.size(); i += 3) {
    EXPECT_NEAR(places[i].get<double>(), 0, 0.011) << "the ground";
  }
  client.call("sim.reset", nullptr);
  EXPECT_EQ(client.call("sim.clouds", nullptr).at("v"), Json::array({Json::array()}));
}

TEST_F(Hilsim, PluginsReadNamedFilesAndWriteResultsAndNothingElse) {
  const cas::test::TemporaryFolder elsewhere;
  elsewhere.write("key", "secret");
  const std::string burglar = "{plugin: fake_burglar, folder: " + elsewhere.path().string();
  const auto figures = [&](const std::string& plugin) {
    ChildProcess hilsim(command(write("realtime", "[" + plugin + "]"), {"--paused"}));
    EXPECT_TRUE(hilsim.wait_ready()) << hilsim.output();
    return Client("unix:" + socket()).call("sim.stats", nullptr)["plugins"]["fake_burglar@iris0"];
  };
  const Json denied = figures(burglar + "}");
  if (denied == Json{{"read", 0}, {"write", 0}}) GTEST_SKIP() << "this kernel has no Landlock";
  EXPECT_EQ(denied, Json({{"read", EACCES}, {"write", EACCES}}));
  const std::string key = (elsewhere.path() / "key").string();
  EXPECT_EQ(figures(burglar + ", named: " + key + "}"), Json({{"read", 0}, {"write", EACCES}}));
}

/// The library of the rays and the pattern's file are opened by a program that reads little else.
TEST_F(Hilsim, CastsTheRaysOfALidar) {
  ChildProcess hilsim(
      command(write("free_run",
                    "[{plugin: lidar, pattern: ../lidars/vlp16.yaml, rate_hz: 10, min_m: 0.1, "
                    "max_m: 40, cloud: ply, cloud_every: 5}]"),
              {"--duration", "0.6"}));
  EXPECT_EQ(hilsim.wait_exit(), 0) << hilsim.output();
  const bool has_embree = std::filesystem::exists(cas::sim::ray_library());
  EXPECT_EQ(hilsim.output().find("rays are cast by ODE") == std::string::npos, has_embree);
  const Json figures = read_stats()["plugins"]["lidar@iris0"];
  EXPECT_EQ(figures["rays"], 6 * 1808 * 16);
  EXPECT_GT(figures["returns"], 6 * 1808 * 7) << "of the beams that look down";
  for (const char* name : {"iris0_000000.ply", "iris0_000005.ply"}) {
    EXPECT_TRUE(std::filesystem::exists(folder_.path() / "out/clouds" / name)) << name;
  }
}

/// PX4's simulator API takes no OBSTACLE_DISTANCE; a companion's link does.
TEST_F(Hilsim, SendsMessagesOfPluginsToACompanion) {
  cas::test::UdpPeer controller;
  cas::test::UdpPeer companion;
  ChildProcess hilsim(command(
      write("free_run",
            "[{plugin: imu}, {plugin: lidar, pattern: ../lidars/vlp16.yaml, rate_hz: 10, min_m: "
            "0.1, max_m: 40, obstacle_height_m: 1}, {plugin: mavlink_interface, transport: udp, "
            "system_id: 1, component_id: 200, local: \"127.0.0.1:0\", remote: \"" +
                controller.endpoint() + "\", companion: \"" + companion.endpoint() + "\"}]"),
      {"--duration", "0.5"}));
  EXPECT_EQ(hilsim.wait_exit(), 0) << hilsim.output();
  constexpr std::uint32_t kObstacleDistance = 330;
  cas::test::PacketStream sensors;
  cas::test::PacketStream obstacles;
  controller.read(sensors);
  companion.read(obstacles);
  EXPECT_GT(sensors.packets().size(), 0U);
  EXPECT_EQ(sensors.count(kObstacleDistance), 0U);
  ASSERT_EQ(obstacles.count(kObstacleDistance), 5U);
  EXPECT_EQ(obstacles.packets().size(), 5U);
  EXPECT_EQ(obstacles.garbage(), 0U);
  EXPECT_EQ(obstacles.packets().front().source.component, 200);
  const Json figures = read_stats()["plugins"]["mavlink_interface@iris0"]["companion"];
  EXPECT_EQ(figures["sent"], 5);
}

/// ArduPilot's JSON interface has no MAVLink.
TEST_F(Hilsim, SendsTheAnglesOfABeaconBesideArdupilotsInterface) {
  cas::test::UdpPeer companion;
  ChildProcess hilsim(command(
      write("free_run",
            "[{plugin: landing_target, beacon: pad, rate_hz: 50, max_m: 20, view_across_deg: 60, "
            "view_along_deg: 60, distance_stddev_m: 0}, {plugin: ardupilot_json, local: "
            "\"127.0.0.1:0\", companion: \"" +
                companion.endpoint() + "\"}]",
            "beacons: [{name: pad, x_m: 0.3, y_m: -0.1}]\n"),
      {"--duration", "0.1"}));
  EXPECT_EQ(hilsim.wait_exit(), 0) << hilsim.output();
  cas::test::PacketStream pictures;
  companion.read(pictures);
  ASSERT_EQ(pictures.packets().size(), 5U);
  const cas::test::PacketStream::Packet& first = pictures.packets().front();
  EXPECT_EQ(first.source, (mav::Source{1, 200}));
  const auto target = mav::decode<mavlink::common::LandingTarget>(first.view());
  ASSERT_TRUE(target);
  EXPECT_EQ(target->time_usec, 20'000U);
  // Its centre of gravity began 1.055 m up and has fallen for 20 ms; nose to the east.
  constexpr double kHeight_m = 1.055 - 0.5 * 9.80665 * 0.02 * 0.02;
  EXPECT_NEAR(target->angle_x, std::atan2(0.1, kHeight_m), 1e-3);
  EXPECT_NEAR(target->angle_y, -std::atan2(0.3, kHeight_m), 1e-3);
  EXPECT_NEAR(target->distance, std::hypot(0.3, 0.1, kHeight_m), 1e-3);
  EXPECT_EQ(target->position_valid, mavlink::common::MavBool::kFalse);
  const Json figures = read_stats()["plugins"];
  EXPECT_EQ(figures["landing_target@iris0"]["seen"], 5);
  EXPECT_EQ(figures["ardupilot_json@iris0"]["companion"]["sent"], 5);
}

TEST_F(Hilsim, AnswersOnItsControlSocket) {
  ChildProcess hilsim(command(write("realtime", "[{plugin: fake_counter}]"), {"--paused"}));
  const auto status = hilsim.wait_ready();
  ASSERT_TRUE(status) << hilsim.output();
  EXPECT_EQ(*status, "fake 1");
  Client client("unix:" + socket());

  Json answer = client.call("sim.status", nullptr);
  EXPECT_EQ(answer["steps"], 0) << "paused at time zero";
  EXPECT_TRUE(answer["paused"]);
  EXPECT_EQ(answer["pace"], "realtime");
  EXPECT_NEAR(answer["vehicles"][0]["p_W"][2].get<double>(), 1.055, 0.01);

  answer = client.call("sim.step", {{"n", 100}});
  EXPECT_EQ(answer["steps"], 100);
  answer = client.call("sim.run_until", {{"time_s", 0.25}});
  EXPECT_EQ(answer["steps"], 250);
  EXPECT_TRUE(answer["paused"]);
  EXPECT_LT(answer["vehicles"][0]["v_W"][2].get<double>(), -2.0) << "it falls";
  answer = client.call("sim.stats", nullptr);
  EXPECT_EQ(answer["plugins"]["fake_counter@iris0"]["post"], 250);
  answer = client.call("sim.reset", nullptr);
  EXPECT_EQ(answer["steps"], 0);
  EXPECT_THROW(client.call("sim.step", {{"n", -1}}), base::rpc::CallError);
  EXPECT_THROW(client.call("sim.run_until", {{"time", 1}}), base::rpc::CallError);

  client.call("sim.resume", nullptr);
  client.call("sim.quit", nullptr);
  EXPECT_EQ(hilsim.wait_exit(), 0);
  EXPECT_EQ(read_stats()["program"], "hilsim");
  EXPECT_TRUE(std::filesystem::exists(folder_.path() / "out" / "finished_iris0"));
}

TEST_F(Hilsim, TellsThePluginsThePhaseOfTheFlight) {
  ChildProcess hilsim(command(
      write("free_run", "[{plugin: fault, faults: [{when: phase == hold, mass_factor: 1.5}]}]"),
      {"--paused"}));
  ASSERT_TRUE(hilsim.wait_ready()) << hilsim.output();
  Client client("unix:" + socket());
  client.call("sim.step", {{"n", 10}});
  EXPECT_THROW(client.call("sim.phase", {{"name", 1}}), base::rpc::CallError);
  client.call("sim.phase", {{"name", "hold"}});
  client.call("sim.step", {{"n", 10}});
  const Json events = client.call("sim.stats", nullptr)["plugins"]["fault@iris0"]["events"];
  ASSERT_EQ(events.size(), 1U);
  EXPECT_EQ(events[0]["time_s"], 0.01);
  client.call("sim.quit", nullptr);
  EXPECT_EQ(hilsim.wait_exit(), 0);
}

TEST_F(Hilsim, TakesFaultsByHandAndNotesWhoDidWhat) {
  ChildProcess hilsim(command(write("free_run", "[{plugin: fault, by_hand: true}]"), {"--paused"}));
  ASSERT_TRUE(hilsim.wait_ready()) << hilsim.output();
  Client client("unix:" + socket());
  const std::string vehicle = client.call("sim.status", nullptr)["vehicles"][0]["name"];
  const Json heavy{{"name", "heavy"}, {"for_s", 1}, {"mass_factor", 1.5}};
  EXPECT_EQ(client.call("sim.fault", {{"vehicle", vehicle}, {"fault", heavy}}), true);
  for (const Json& wrong : {Json{{"vehicle", "nobody"}, {"fault", heavy}},
                            Json{{"vehicle", vehicle}, {"fault", {{"mass_factor", 99}}}},
                            Json{{"vehicle", vehicle}, {"fault", {{"at_s", 9}}}},
                            Json{{"vehicle", vehicle}, {"fault", 7}}, Json{{"vehicle", vehicle}}}) {
    EXPECT_THROW(client.call("sim.fault", wrong), base::rpc::CallError) << wrong;
  }
  client.call("sim.step", {{"n", 10}});
  const Json events = client.call("sim.stats", nullptr)["plugins"]["fault@iris0"]["events"];
  ASSERT_EQ(events.size(), 1U);
  EXPECT_EQ(events[0]["fault"], "heavy");
  hilsim.signal(SIGHUP);
  ASSERT_TRUE(wait_until([&] { return client.call("sim.status", nullptr)["steps"] == 0; }));
  const Json calls = client.call("sim.journal", nullptr)["calls"];
  ASSERT_EQ(calls.size(), 3U) << calls;
  EXPECT_EQ(calls[0]["method"], "sim.fault");
  EXPECT_EQ(calls[0]["params"]["fault"], heavy);
  EXPECT_EQ(calls[1]["method"], "sim.step");
  EXPECT_NE(calls[1]["client"].get<std::string>().find("unix:uid "), std::string::npos);
  EXPECT_EQ(calls[2]["client"], "signal");
  EXPECT_EQ(calls[2]["time_s"], 0.01);
  client.call("sim.quit", nullptr);
  EXPECT_EQ(hilsim.wait_exit(), 0);
}

TEST_F(Hilsim, RealTimeRunEndsAtTheTerminationSignal) {
  ChildProcess hilsim(command(write("realtime", "[{plugin: fake_counter}]")));
  ASSERT_TRUE(hilsim.wait_ready()) << hilsim.output();
  Client client("unix:" + socket());
  ASSERT_TRUE(
      wait_until([&] { return client.call("sim.status", nullptr)["steps"].get<int>() > 100; }));
  hilsim.signal(SIGTERM);
  EXPECT_EQ(hilsim.wait_exit(), 0) << hilsim.output();
  const Json stats = read_stats();
  EXPECT_GT(stats["steps"], 100);
  for (const char* name : {"step_us", "lateness_us"}) {
    std::uint64_t entries = 0;
    for (const Json& bin : stats[name]["histogram"]) entries += bin[1].get<std::uint64_t>();
    EXPECT_EQ(entries, stats["steps"]) << name;
    EXPECT_EQ(stats[name]["count"], stats["steps"]) << name;
  }
  EXPECT_LT(stats["real_time_factor"], 1.02);
}

TEST_F(Hilsim, SignalsPauseStepAndReset) {
  ChildProcess hilsim(command(write("realtime"), {"--paused"}));
  ASSERT_TRUE(hilsim.wait_ready()) << hilsim.output();
  Client client("unix:" + socket());
  const auto steps = [&] { return client.call("sim.status", nullptr)["steps"].get<int>(); };
  hilsim.signal(SIGUSR2);
  EXPECT_TRUE(wait_until([&] { return steps() == 1; }));
  hilsim.signal(SIGUSR1);
  EXPECT_TRUE(wait_until([&] { return steps() > 10; }));
  hilsim.signal(SIGUSR1);
  EXPECT_TRUE(wait_until([&] { return client.call("sim.status", nullptr)["paused"].get<bool>(); }));
  hilsim.signal(SIGHUP);
  EXPECT_TRUE(wait_until([&] { return steps() == 0; }));
  hilsim.signal(SIGRTMIN);
  EXPECT_TRUE(
      wait_until([&] { return hilsim.output().find("0.000 s, paused") != std::string::npos; }));
  hilsim.signal(SIGINT);
  EXPECT_EQ(hilsim.wait_exit(), 0);
}

TEST_F(Hilsim, EndsByItselfAfterItsDuration) {
  ChildProcess hilsim(command(write("free_run"), {"--duration", "20"}));
  EXPECT_EQ(hilsim.wait_exit(), 0) << hilsim.output();
  EXPECT_EQ(read_stats()["steps"], 20000);
}

TEST_F(Hilsim, RefusesWithOneSentenceAndExitCode78) {
  const auto refuse = [&](const std::vector<std::string>& arguments) {
    ChildProcess hilsim(arguments);
    EXPECT_EQ(hilsim.wait_exit(), 78);
    return hilsim.output();
  };
  EXPECT_THAT(refuse({kHilsim}), HasSubstr("config is required"));
  EXPECT_THAT(refuse({kHilsim, "/nowhere.yaml"}), HasSubstr("hilsim: /nowhere.yaml: no such file"));
  EXPECT_THAT(refuse(command(write("realtime", "[{plugin: fake_wrong_abi}]"))),
              HasSubstr("rebuild it"));
  EXPECT_THAT(refuse(command(write("realtime", "[{plugin: fake_throws_in_configure}]"))),
              HasSubstr("the sensor is not there"));
  EXPECT_THAT(refuse(command(write("realtime"), {"--log-level", "loud"})), HasSubstr("loud"));
}

/// A supervisor tries again, as it does not for a wrong file.
TEST_F(Hilsim, RefusesATakenUdpPortWithExitCode71) {
  cas::test::UdpPeer taken;
  const std::string plugin =
      "[{plugin: mavlink_interface, transport: udp, system_id: 1, component_id: 200, local: \"" +
      taken.endpoint() + "\", remote: \"127.0.0.1:9\"}]";
  ChildProcess hilsim(command(write("realtime", plugin)));
  EXPECT_EQ(hilsim.wait_exit(), 71);
  EXPECT_THAT(hilsim.output(), HasSubstr("local: cannot be bound: Address already in use"));
}

TEST_F(Hilsim, RefusesATakenControlSocketWithExitCode71) {
  const std::vector<std::string> hilsim = command(write("realtime"), {"--paused"});
  ChildProcess first(hilsim);
  ASSERT_TRUE(first.wait_ready()) << first.output();
  ChildProcess second(hilsim);
  EXPECT_EQ(second.wait_exit(), 71);
  EXPECT_THAT(second.output(), HasSubstr("is in use by another program"));
}

}  // namespace
}  // namespace cas::sim
