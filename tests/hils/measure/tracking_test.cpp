// SPDX-License-Identifier: BSD-3-Clause
#include "hils/measure/tracking.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <span>
#include <string>
#include <vector>

#include "mavlink/common/attitude.hpp"
#include "mavlink/common/local_position_ned.hpp"
#include "mavlink_gen/runtime/codec.hpp"
#include "tests/support/refusal.hpp"

namespace cas::hils {
namespace {

constexpr const char* kHeader =
    "time_s,x_m,y_m,z_m,vx_m_s,vy_m_s,vz_m_s,roll_rad,pitch_rad,yaw_rad,p_rad_s,q_rad_s,r_rad_s,"
    "omega1_rad_s,omega2_rad_s,omega3_rad_s,omega4_rad_s";

class TrajectoryFile : public testing::Test {
 protected:
  void TearDown() override { std::filesystem::remove(file_); }
  std::filesystem::path file_ =
      std::filesystem::path(testing::TempDir()) /
      (std::string(testing::UnitTest::GetInstance()->current_test_info()->name()) +
       std::to_string(::getpid()));
};

TEST_F(TrajectoryFile, ReadsTruthInTheRecordersColumns) {
  std::ofstream(file_) << kHeader
                       << "\n"
                          "0,1,2,3,0,0,0,0.1,0.2,0.3,0,0,0,500,500,500,500\n"
                          "0.01,1.5,2,3e-1,0,0,0,0.1,0.2,-0.3,0,0,0,500,500,500,500\n";
  const auto samples = read_truth(file_);
  ASSERT_EQ(samples.size(), 2U);
  EXPECT_EQ(samples[1].time_us, 10'000);
  EXPECT_DOUBLE_EQ(samples[1].pose.x_m, 1.5);
  EXPECT_DOUBLE_EQ(samples[1].pose.z_m, 0.3);
  EXPECT_DOUBLE_EQ(samples[1].pose.yaw_rad, -0.3);
}

TEST_F(TrajectoryFile, ReadsTheAirspeedBehindTheRotors) {
  std::ofstream(file_) << kHeader
                       << ",airspeed_m_s\n"
                          "0,1,2,3,0,0,0,0.1,0.2,0.3,0,0,0,500,600,700,800,15.5\n";
  const auto samples = read_truth(file_);
  ASSERT_EQ(samples.size(), 1U);
  EXPECT_EQ(samples[0].rotors, 4);
  EXPECT_DOUBLE_EQ(samples[0].omega_rad_s[3], 800);
  EXPECT_EQ(samples[0].airspeed_m_s, 15.5);
}

TEST_F(TrajectoryFile, RefusesAnotherHeader) {
  std::ofstream(file_) << "time_s,x_m\n0,1\n";
  const std::string said = test::refusal([&] { read_truth(file_); });
  EXPECT_NE(said.find(":1: not a header of truth.csv"), std::string::npos) << said;
}

TEST_F(TrajectoryFile, NamesTheLineThatIsNoRow) {
  std::ofstream(file_) << kHeader << "\n0,1,2,oops\n";
  const std::string said = test::refusal([&] { read_truth(file_); });
  EXPECT_NE(said.find(":2:"), std::string::npos) << said;
}

void append(std::ofstream& log, std::uint64_t stamp_us, std::span<const std::uint8_t> packet) {
  for (int shift = 56; shift >= 0; shift -= 8) log.put(static_cast<char>(stamp_us >> shift & 0xFF));
  log.write(reinterpret_cast<const char*>(packet.data()),
            static_cast<std::streamsize>(packet.size()));
}

TEST_F(TrajectoryFile, ReadsTheEstimateOfOneSystemFromAFlightLog) {
  mav::Encoder vehicle(mav::Source{1, 1});
  mav::Encoder other(mav::Source{2, 1});
  mavlink::common::Attitude attitude{.yaw = 0.5F};
  mavlink::common::LocalPositionNed position{.x = 1, .y = -2, .z = -2.5F};
  {
    std::ofstream log(file_, std::ios::binary);
    append(log, 900, vehicle(position));  // no attitude known yet
    append(log, 1000, vehicle(attitude));
    append(log, 1500, other(position));
    log << "rubbish";
    append(log, 2000, vehicle(position));
  }
  ClockMap clock;
  clock.add(1500, 0);
  const auto samples = read_estimate(file_, 1, clock);
  ASSERT_EQ(samples.size(), 1U);
  EXPECT_EQ(samples[0].time_us, 500);
  EXPECT_DOUBLE_EQ(samples[0].pose.y_m, -2);
  EXPECT_DOUBLE_EQ(samples[0].pose.z_m, 2.5);
  EXPECT_DOUBLE_EQ(samples[0].pose.yaw_rad, 0.5);
}

TEST(ClockMap, InterpolatesBetweenReadingsAndRunsAlikeBeyondThem) {
  ClockMap clock;
  clock.add(1000, 0);
  clock.add(2000, 500);  // the simulation ran at half the pace
  EXPECT_EQ(clock.to_sim_us(900), -100);
  EXPECT_EQ(clock.to_sim_us(1500), 250);
  EXPECT_EQ(clock.to_sim_us(2100), 600);
}

TEST(Rms, IsTheRootOfTheMeanSquareAboutTheReference) {
  const std::vector<PoseSample> samples{{0, {.x_m = 3, .z_m = 2.5}}, {1, {.x_m = -4, .z_m = 2.5}}};
  const RmsFigures rms = rms_about(samples, [](std::int64_t) { return Pose{.z_m = 2.5}; });
  EXPECT_DOUBLE_EQ(rms.x_m, std::sqrt(12.5));
  EXPECT_DOUBLE_EQ(rms.z_m, 0);
}

TEST(Rms, TakesTheShortWayRoundForYaw) {
  const std::vector<PoseSample> samples{{0, {.yaw_rad = M_PI - 0.1}}};
  const auto reference = [](std::int64_t) { return Pose{.yaw_rad = -M_PI + 0.1}; };
  EXPECT_NEAR(rms_about(samples, reference).yaw_rad, 0.2, 1e-12);
}

TEST(PeakError, IsTheFarthestDistanceFromTheReference) {
  const std::vector<PoseSample> samples{{.time_us = 0, .pose = {.x_m = 4, .y_m = 4, .z_m = 1}},
                                        {.time_us = 1, .pose = {.x_m = 1, .y_m = 0, .z_m = 3}}};
  const auto reference = [](std::int64_t) { return Pose{.x_m = 1, .z_m = 1}; };
  EXPECT_DOUBLE_EQ(peak_error_m(samples, reference), 5);
}

TEST(RotorActivity, IsTheRmsOfTheAccelerationsOfAllRotors) {
  const std::vector<PoseSample> samples{
      {.time_us = 0, .rotors = 2, .omega_rad_s = {500, 400}},
      {.time_us = 10'000, .rotors = 2, .omega_rad_s = {503, 396}},
      {.time_us = 20'000, .rotors = 2, .omega_rad_s = {503, 396}}};
  EXPECT_NEAR(rotor_activity_rad_s2(samples), std::sqrt((300.0 * 300 + 400 * 400) / 4), 1e-9);
  EXPECT_EQ(rotor_activity_rad_s2({}), 0);
}

TEST(Between, TakesTheBeginAndLeavesTheEnd) {
  const std::vector<PoseSample> samples{{0, {}}, {10, {}}, {20, {}}, {30, {}}};
  EXPECT_EQ(between(samples, 10, 30).size(), 2U);
  EXPECT_TRUE(between(samples, 40, 50).empty());
}

}  // namespace
}  // namespace cas::hils
