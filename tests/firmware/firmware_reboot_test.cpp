// SPDX-License-Identifier: BSD-3-Clause
// Stock firmware that hils ends and starts again between steps.
#include <nlohmann/json.hpp>

#include "tests/firmware/sitl_flight.hpp"

namespace cas::test {
namespace {

constexpr const char* kRebootFirst = R"(  - setparam: {MPC_Z_VEL_MAX_UP: 1.5, MIS_TAKEOFF_ALT: 4}
  - setparam: {MIS_TAKEOFF_ALT: 3}
  - reboot: {timeout_s: 120}
  - arm: {timeout_s: 100}
  - takeoff: {altitude_m: 4, timeout_s: 200}
  - hold: {duration_s: 1, measure: true}
  - land: {timeout_s: 100}
  - disarm: {timeout_s: 50}
)";

class FirmwareRebooted : public SitlFlight {
 protected:
  /// Stages of the flight by their step's word.
  std::vector<std::string> stages() const {
    std::vector<std::string> words;
    const nlohmann::json figures = summary();
    for (const nlohmann::json& stage : figures.at("stages")) {
      words.push_back(stage.at("step").get<std::string>());
    }
    return words;
  }
};

TEST_F(FirmwareRebooted, KeepsItsParametersAndFlies) {
  first_step_.clear();
  start("obedient", "", kRebootFirst);
  ASSERT_EQ(fly(), 0) << output();
  EXPECT_EQ(stages().at(2), "reboot") << summary().dump(2);
  const std::string kept = content(folder_.path() / "out/run/firmware/parameters");
  EXPECT_NE(kept.find("MPC_Z_VEL_MAX_UP 1.5"), std::string::npos) << kept;
}

TEST_F(FirmwareRebooted, FliesBeforeAndAfterwards) {
  start("obedient", "", R"(  - takeoff: {altitude_m: 2, timeout_s: 200}
  - hold: {duration_s: 1}
  - land: {timeout_s: 100}
  - disarm: {timeout_s: 50}
  - reboot: {timeout_s: 120}
  - arm: {timeout_s: 100}
)" + std::string(kOneFlight));
  ASSERT_EQ(fly(), 0) << output();
  EXPECT_EQ(armings(), 2);
}

TEST_F(FirmwareRebooted, FailsWhereItHasForgottenAParameter) {
  first_step_.clear();
  start("forgetful", "", kRebootFirst);
  EXPECT_EQ(fly(), 1) << output();
  EXPECT_TRUE(says("the reboot has lost a parameter: MPC_Z_VEL_MAX_UP was set to 1.5, and is 3"))
      << output();
}

}  // namespace
}  // namespace cas::test
