// SPDX-License-Identifier: BSD-3-Clause
// Several instances of stock firmware in one run.
#include <gmock/gmock.h>

#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <utility>

#include "casd/tlog/tlog_packets.hpp"
#include "mavlink/common/all.hpp"
#include "mavlink/common/table.hpp"
#include "mavlink_gen/runtime/codec.hpp"
#include "tests/firmware/shipped_text.hpp"
#include "tests/support/child_process.hpp"
#include "tests/support/temporary_folder.hpp"

namespace cas::test {
namespace {

using testing::HasSubstr;

namespace mv = mavlink::common;

/// Two scripted PX4 in software, flown by hils as fast as they can.
class FirmwareFleet : public testing::Test {
 protected:
  /// @param word  how both behave
  /// @return exit code of hils
  std::optional<int> fly(const std::string& word, const std::string& steps,
                         const std::string& more = "") {
    folder_.write("world.yaml", ports_.world());
    folder_.write("topology.yaml", ports_.topology());
    if (swapped_) std::swap(ports_.simulator[0], ports_.simulator[1]);
    const auto scenario = folder_.write(
        "scenario.yaml", R"(schema: 1
name: fleet
world: world.yaml
topology: topology.yaml
not_hil: true
steps:
)" + steps + more + "firmware: {command: ['" +
                             binary_dir() + "/tests/scripted_firmware', px4-sitl, " +
                             ports_.arguments() + ", " + word + ", -i, '${CAS_INSTANCE}']}\n");
    hils_.emplace(std::vector<std::string>{binary_dir() + "/bin/hils", "run", scenario.string(),
                                           "--out", folder_ / "out"});
    return hils_->wait_exit(std::chrono::minutes(3));
  }

  nlohmann::json summary() const {
    return nlohmann::json::parse(content(folder_.path() / "out/summary.json"));
  }
  std::string output() const { return hils_->output(); }

  TemporaryFolder folder_;
  TwoPx4SitlPorts ports_;
  bool swapped_ = false;  ///< each instance joins the port of the other's vehicle
  std::optional<ChildProcess> hils_;
};

/// When each vehicle's first command of a kind was given, by the flight log, in us.
std::map<int, std::uint64_t> first_commands(const std::filesystem::path& tlog, mv::MavCmd kind) {
  std::map<int, std::uint64_t> times;
  casd::for_each_tlog_packet(tlog, mv::table(),
                             [&](std::uint64_t time_us, const mav::PacketView& packet) {
                               const auto command = mav::decode<mv::CommandLong>(packet);
                               if (!command || command->command != kind) return;
                               times.emplace(command->target_system, time_us);
                             });
  return times;
}

TEST_F(FirmwareFleet, FliesItsStepsTogetherAndIsJudgedOneByOne) {
  ASSERT_EQ(fly("plain", R"(  - arm: {timeout_s: 100}
  - takeoff: {altitude_m: 2, timeout_s: 200}
  - hold: {duration_s: 2, measure: true}
  - goto: {east_m: 2, north_m: 0, up_m: 2, timeout_s: 100, vehicle: right}
  - land: {timeout_s: 100}
  - disarm: {timeout_s: 50}
)",
                "limits: {height_error_m: 1, drift_m: 1, rms_estimate: {x_m: 1, z_m: 1}}\n"),
            0)
      << output();
  const nlohmann::json figures = summary();
  ASSERT_EQ(figures.at("vehicles").size(), 2U) << figures.dump(2);
  for (int i = 0; i < 2; ++i) {
    const nlohmann::json& vehicle = figures.at("vehicles").at(i);
    EXPECT_EQ(vehicle.at("name"), i == 0 ? "left" : "right");
    EXPECT_EQ(vehicle.at("system"), i + 1);
    EXPECT_TRUE(vehicle.at("passed").get<bool>());
    EXPECT_EQ(vehicle.at("stages").size(), 6U);
    EXPECT_LT(vehicle.at("rms_estimate").at("x_m").get<double>(), 1);
    EXPECT_TRUE(std::filesystem::is_directory(
        folder_.path() / "out/run" / ("firmware_" + vehicle.at("name").get<std::string>())))
        << "a folder of its own";
  }
  // A step begins for both at the same moment.
  const auto begins = [&](int vehicle, int stage) {
    return figures["vehicles"][vehicle]["stages"][stage]["begin_s"].get<double>();
  };
  for (int stage = 1; stage < 5; ++stage) EXPECT_NEAR(begins(0, stage), begins(1, stage), 0.2);
  for (const auto kind : {mv::MavCmd::kComponentArmDisarm, mv::MavCmd::kNavTakeoff}) {
    EXPECT_EQ(first_commands(folder_.path() / "out/flight.tlog", kind).size(), 2U);
  }
  for (const char* words : {"left: Flight", "right: Flight", "right: Limits"}) {
    EXPECT_THAT(content(folder_.path() / "out/report.html"), HasSubstr(words)) << words;
  }
  EXPECT_THAT(content(folder_.path() / "out/junit.xml"), HasSubstr("hils.fleet.sitl.right"));
}

TEST_F(FirmwareFleet, FailsWhereEachFliesTheVehicleOfTheOther) {
  swapped_ = true;
  EXPECT_EQ(fly("plain", R"(  - arm: {timeout_s: 100}
  - takeoff: {altitude_m: 2, timeout_s: 200}
  - hold: {duration_s: 1, measure: true}
  - land: {timeout_s: 100}
  - disarm: {timeout_s: 50}
)"),
            1)
      << output();
  EXPECT_THAT(output(), HasSubstr("left: system 1 has its home where vehicle 'right' started"));
}

TEST_F(FirmwareFleet, FailsWithTheOneThatCannotGoOn) {
  EXPECT_EQ(fly("plain", R"(  - arm: {timeout_s: 100}
  - takeoff: {altitude_m: 2, timeout_s: 200}
  - hold: {duration_s: 1, measure: true}
  - goto: {east_m: 400, north_m: 0, up_m: 2, timeout_s: 5, vehicle: right}
  - land: {timeout_s: 100}
)"),
            1)
      << output();
  const nlohmann::json figures = summary();
  EXPECT_THAT(figures["vehicles"][1]["failures"].dump(), HasSubstr("was not done within 5 s"))
      << figures.dump(2);
  EXPECT_THAT(figures["vehicles"][0]["failures"].dump(), HasSubstr("it ended with that of right"));
  EXPECT_THAT(
      output(),
      HasSubstr("right: the flight was not completed: step 4 (goto) was not done within 5 s"));
}

}  // namespace
}  // namespace cas::test
