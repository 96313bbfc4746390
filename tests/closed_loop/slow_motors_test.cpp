// SPDX-License-Identifier: BSD-3-Clause
// Gains that know the lag of the motors.
#include <gtest/gtest.h>

#include <string>

#include "tests/closed_loop/flight_fixture.hpp"
#include "tests/support/temporary_folder.hpp"

namespace cas::hils::test {
namespace {

/// The shipped quadrotor with motors as slow as those of large propellers.
std::filesystem::path slow_quad(const cas::test::TemporaryFolder& folder,
                                const std::string& lag_s) {
  const std::string config = cas::test::source_dir() + "/config/vehicles/";
  std::string text = content(config + "quad_x.yaml");
  for (const auto& [from, to] :
       {std::pair<std::string, std::string>{"urdf: quad_x.urdf", "urdf: " + config + "quad_x.urdf"},
        {"time_constant_up_s: 0.02", "time_constant_up_s: " + lag_s},
        {"time_constant_down_s: 0.03", "time_constant_down_s: " + lag_s}}) {
    const std::size_t at = text.find(from);
    EXPECT_NE(at, std::string::npos) << from;
    text.replace(at, from.size(), to);
  }
  return folder.write("slow.yaml", text);
}

constexpr const char* kFlight = R"(
home: {lat_deg: 47.397742, lon_deg: 8.545594, alt_m: 488.0}
seed: 1
rates: {sensor_hz: 500, gps_hz: 5, controls_hz: 400}
sensors: rtk
line: {preset: baud_921600}
steps:
  - arm
  - takeoff: {altitude_m: 5}
  - goto: {north_m: 10, east_m: 0, up_m: 5, timeout_s: 60}
  - hold: {duration_s: 8}
  - hold: {duration_s: 10, measure: true}
  - land: {timeout_s: 60}
limits: {rms: {x_m: 0.1, y_m: 0.1, z_m: 0.1}}
)";

class SlowMotors : public testing::TestWithParam<const char*> {};

TEST_P(SlowMotors, FlyToAPlaceAndHold) {
  const cas::test::TemporaryFolder folder;
  const auto file =
      folder.write("slow_flight.yaml",
                   "schema: 1\nvehicle: " + slow_quad(folder, GetParam()).string() + kFlight);
  const Flight flight(Scenario::load(file), 1, "slow_motors");
  EXPECT_TRUE(flight.verdict().passed) << flight.text();
}

INSTANTIATE_TEST_SUITE_P(Lag, SlowMotors, testing::Values("0.05", "0.08", "0.15", "0.20"),
                         [](const auto& test) {
                           return "Of" + std::string(test.param).substr(2) + "Hundredths";
                         });

}  // namespace
}  // namespace cas::hils::test
