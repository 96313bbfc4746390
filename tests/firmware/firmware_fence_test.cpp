// SPDX-License-Identifier: BSD-3-Clause
// Stock firmware at its own fence, flown there by hils: the shipped scenarios with scripted peers.
#include <signal.h>

#include <bit>
#include <map>
#include <nlohmann/json.hpp>

#include "tests/firmware/sitl_flight.hpp"

namespace cas::test {
namespace {

/// A second of PX4's clock, after which it takes setpoints for lost, is a third of one here.
constexpr const char* kThreeTimesRealTime = "\nspeed: 3\n";
constexpr double kRadius_m = 15;
constexpr double kMargin_m = 5;

/// From one line of a shipped scenario to the end of that paragraph.
std::string paragraph(const std::string& scenario, const std::string& begin) {
  const std::string text = content(kConfig / "scenarios" / (scenario + ".yaml"));
  const std::size_t at = text.find("\n" + begin) + 1;
  EXPECT_NE(at, 0U) << begin;
  return at == 0 ? "" : text.substr(at, text.find("\n\n", at) - at) + "\n";
}

/// Values that casd wrote into each parameter, in their order.
std::map<std::string, std::vector<double>> written(const std::filesystem::path& tlog) {
  std::map<std::string, std::vector<double>> values;
  casd::for_each_tlog_packet(tlog, mv::table(), [&](std::uint64_t, const mav::PacketView& packet) {
    const auto set = mav::decode<mv::ParamSet>(packet);
    if (!set || packet.source != kCasd) return;
    const bool bytes = set->param_type == mv::MavParamType::kInt32;
    values[std::string(mav::text(set->param_id))].push_back(
        bytes ? std::bit_cast<std::int32_t>(set->param_value)
              : static_cast<double>(set->param_value));
  });
  return values;
}

class FirmwareFence : public SitlFlight {
 protected:
  FirmwareFence() { pace_ = kThreeTimesRealTime; }

  /// The shipped PX4 scenario.
  /// @param fence  its section, as it is or changed
  void start_shipped(const std::string& word, const std::string& fence = shipped_fence()) {
    const std::string steps = paragraph("px4_geofence", "  - takeoff");
    start(word, fence, replaced(steps, "timeout_s: 60}", "timeout_s: 40}"));
  }
  static std::string shipped_fence() { return paragraph("px4_geofence", "geofence:"); }

  void expect_restored() const {
    const auto values = written(folder_.path() / "out/flight.tlog");
    ASSERT_TRUE(values.contains("GF_ACTION"));
    EXPECT_EQ(values.at("GF_MAX_HOR_DIST").front(), kRadius_m);
    EXPECT_EQ(values.at("GF_MAX_HOR_DIST").back(), 0);
    EXPECT_EQ(values.at("GF_ACTION").back(), 2) << "PX4's default";
    EXPECT_FALSE(std::filesystem::exists(folder_.path() / "out/run/fence_before.params"));
  }
  /// The shipped ArduCopter scenario, with ports of its own.
  void start_copter() {
    const std::string json = std::to_string(free_port());
    const std::string here = std::to_string(free_port());
    const auto topology = replaced(content(kConfig / "topologies/ardupilot_sitl.yaml"),
                                   "local: 127.0.0.1:14550", "local: 127.0.0.1:" + here);
    folder_.write(
        "world.yaml",
        with_whole_paths(replaced(content(kConfig / "worlds/ardupilot.yaml"),
                                  "# local: 127.0.0.1:9002", "local: 127.0.0.1:" + json + "  #")));
    folder_.write("topology.yaml", with_whole_paths(replaced(topology, "local: 127.0.0.1:14551",
                                                             "local: 127.0.0.1:0")));
    const auto scenario = folder_.write(
        "scenario.yaml",
        "schema: 1\nname: copter\nworld: world.yaml\ntopology: topology.yaml\n"
        "not_hil: true\n" +
            paragraph("ardupilot_geofence", "geofence:") +
            paragraph("ardupilot_geofence", "steps:") + "firmware: {command: ['" + binary_dir() +
            "/tests/scripted_firmware', ardupilot, '" + json + "', '" + here + "']}\n");
    hils_.emplace(std::vector<std::string>{binary_dir() + "/bin/hils", "run", scenario.string(),
                                           "--out", folder_ / "out"});
  }
  std::map<std::string, std::vector<double>> written_so_far() const {
    return written(folder_.path() / "out/flight.tlog");
  }
  void expect_copter_restored() const {
    const auto values = written_so_far();
    EXPECT_EQ(values.at("FENCE_ENABLE"), (std::vector<double>{1, 0}));
    EXPECT_EQ(values.at("FENCE_TYPE"), (std::vector<double>{2, 7}));
    EXPECT_EQ(values.at("FENCE_RADIUS"), (std::vector<double>{kRadius_m, 300}));
    EXPECT_FALSE(std::filesystem::exists(folder_.path() / "out/run/fence_before.params"));
  }
};

TEST_F(FirmwareFence, HoldsPx4WithinItsMargin) {
  start_shipped("obedient");
  ASSERT_EQ(fly(), 0) << output();
  const nlohmann::json fence = summary().at("fence");
  EXPECT_EQ(fence.at("announced"), "Geofence: exceeding maximum distance to Home") << fence;
  EXPECT_GT(fence.at("farthest_m").get<double>(), kRadius_m);
  EXPECT_LT(fence.at("farthest_m").get<double>(), kRadius_m + kMargin_m);
  expect_restored();
}

TEST_F(FirmwareFence, SendsPx4Home) {
  start_shipped("obedient", replaced(shipped_fence(), "action: hold", "action: return"));
  ASSERT_EQ(fly(), 0) << output();
  const auto values = written(folder_.path() / "out/flight.tlog");
  EXPECT_EQ(values.at("GF_ACTION").front(), 3);
  expect_restored();
}

TEST_F(FirmwareFence, ThatNeverActsIsAFailure) {
  start_shipped("unfenced");
  EXPECT_EQ(fly(), 1) << output();
  EXPECT_TRUE(says("(breach) was not done within 40 s")) << output();
  EXPECT_TRUE(says("the autopilot did not announce a breach of its fence")) << output();
  EXPECT_TRUE(says("farthest from home: ")) << output();
  expect_restored();
}

TEST_F(FirmwareFence, ThatActsInSilenceIsAFailure) {
  start_shipped("mute");
  EXPECT_EQ(fly(), 1) << output();
  EXPECT_TRUE(says("the autopilot did not announce a breach of its fence")) << output();
  EXPECT_FALSE(says("was not done within")) << output();
}

/// Ctrl-C at hils, on the way to the fence.
TEST_F(FirmwareFence, IsTakenBackWhenHilsIsStopped) {
  start_shipped("obedient");
  bool stopped = false;
  const auto code = fly([&](const mav::PacketView& packet) {
    const auto beat = mav::decode<mv::Heartbeat>(packet);
    constexpr std::uint32_t kOffboard = 6U << 16U;
    if (stopped || !beat || packet.source != kVehicle || beat->custom_mode != kOffboard) return;
    stopped = true;
    hils_->signal(SIGINT);
  });
  EXPECT_EQ(code, 130) << output();
  EXPECT_TRUE(stopped);
  expect_restored();
}

TEST_F(FirmwareFence, SendsArducopterHome) {
  start_copter();
  ASSERT_EQ(hils_->wait_exit(kFlightPatience), 0) << output();
  EXPECT_EQ(summary().at("fence").at("announced"), "Fence Breached");
  expect_copter_restored();
}

TEST_F(FirmwareFence, OfArducopterIsTakenBackWhenHilsIsStopped) {
  start_copter();
  ASSERT_TRUE(wait_until(
      [&] {
        return std::filesystem::exists(folder_.path() / "out/flight.tlog") &&
               written_so_far().contains("FENCE_ENABLE");
      },
      kFlightPatience))
      << output();
  hils_->signal(SIGINT);
  EXPECT_EQ(hils_->wait_exit(kFlightPatience), 130) << output();
  expect_copter_restored();
}

}  // namespace
}  // namespace cas::test
