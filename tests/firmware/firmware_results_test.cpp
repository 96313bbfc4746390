// SPDX-License-Identifier: BSD-3-Clause
// Inputs and results of a flight of stock firmware, beside its steps.
#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>

#include "tests/firmware/sitl_flight.hpp"

namespace cas::test {
namespace {

class FirmwareResults : public SitlFlight {};

TEST_F(FirmwareResults, HaveFaultsFiguresAndAReport) {
  start("obedient", R"(sensors: {preset: rtk, imu: {rate_hz: 250}}
plugins:
  - {plugin: wind, mean_m_s: 2, from_deg: 270}
faults:
  - {name: squall, when: phase == hold, gust: {amplitude_m_s: [2, 0, 0], length_m: 5, hold_s: 0.2}}
limits: {rms_estimate: {x_m: 0.5, z_m: 0.5}, rates_hz: {ATTITUDE: 5}, hop_p99_us: 10000000})");
  ASSERT_EQ(fly(), 0) << output();
  const nlohmann::json figures = summary();
  EXPECT_GT(figures.at("rms_estimate").at("z_m").get<double>(), 0);
  EXPECT_GT(figures.at("rates_hz").at("ATTITUDE").get<double>(), 5);
  ASSERT_EQ(figures.at("faults").size(), 1U) << figures.dump(2);
  EXPECT_EQ(figures.at("faults").at(0).at("name"), "squall");
  const std::string report = left("report.html");
  for (const char* words : {"PASSED", "rate of ATTITUDE", "squall", "its own estimate", "<svg"}) {
    EXPECT_NE(report.find(words), std::string::npos) << words;
  }
}

/// Longest time between two ATTITUDE of the vehicle in the flight log, s.
struct Gaps {
  double wall_s = 0;
  double vehicle_s = 0;  ///< by the vehicle's clock
};

Gaps gaps_of(const std::filesystem::path& tlog) {
  Gaps gaps;
  std::uint64_t last_us = 0;
  std::uint32_t last_ms = 0;
  casd::for_each_tlog_packet(
      tlog, mv::table(), [&](std::uint64_t time_us, const mav::PacketView& packet) {
        const auto attitude = mav::decode<mv::Attitude>(packet);
        if (!attitude || packet.source != kVehicle) return;
        if (last_us != 0 && attitude->time_boot_ms >= last_ms) {
          gaps.wall_s = std::max(gaps.wall_s, 1e-6 * static_cast<double>(time_us - last_us));
          gaps.vehicle_s = std::max(gaps.vehicle_s,
                                    1e-3 * static_cast<double>(attitude->time_boot_ms - last_ms));
        }
        last_us = time_us;
        last_ms = attitude->time_boot_ms;
      });
  return gaps;
}

TEST_F(FirmwareResults, HaveAPauseOfTheSimulatorInWhichTheFirmwaresTimeStandsStill) {
  start("obedient", R"(faults:
  - {name: pause, when: phase == hold, pause: hilsim, for_s: 1.5}
)");
  ASSERT_EQ(fly(), 0) << output();
  const Gaps gaps = gaps_of(folder_.path() / "out/flight.tlog");
  EXPECT_GT(gaps.wall_s, 1.2);
  EXPECT_LT(gaps.vehicle_s, 1);
}

TEST_F(FirmwareResults, HaveACutLinkAfterWhichTheFlightGoesOn) {
  start("obedient", R"(faults:
  - {name: cut, when: phase == hold, cut: px4, for_s: 4}
  - {name: meanwhile, when: phase == hold, reload: casd, for_s: 1}
  - {name: again, when: phase == land, reload: casd, for_s: 1}
)");
  ASSERT_EQ(fly(), 0) << output();
  // The scripted vehicle's time flies: a busy machine begins the cut a second or two of it late.
  // Without a cut the messages are a tenth of a second apart.
  EXPECT_GT(gaps_of(folder_.path() / "out/flight.tlog").vehicle_s, 1);
  const nlohmann::json faults = summary().at("faults");
  ASSERT_EQ(faults.size(), 3U);
  for (const nlohmann::json& fault : faults) EXPECT_FALSE(fault.contains("began"));
}

TEST_F(FirmwareResults, MissALimitThatTheFlightDoesNotKeep) {
  start("obedient", "limits: {rates_hz: {ATTITUDE: 9000}, rms_estimate: {z_m: 0}}");
  EXPECT_EQ(fly(), 1) << output();
  EXPECT_TRUE(says("rate of ATTITUDE: ")) << output();
  EXPECT_TRUE(says("RMS error of the estimate, z_m: ")) << output();
  EXPECT_EQ(summary().at("failures").size(), 2U);
}

TEST_F(FirmwareResults, HaveNoVerdictWhereAFaultNeverBegan) {
  start("obedient", R"(faults:
  - {name: late, at_s: 80000, drop: gps, for_s: 1}
  - {name: high, when: altitude > 500, drop: gps, for_s: 1}
)");
  EXPECT_EQ(fly(), 3) << output();
  EXPECT_TRUE(says("fault 'late' never began: the flight ended before its time")) << output();
  EXPECT_TRUE(says("fault 'high' never began: its condition never came true")) << output();
  EXPECT_EQ(summary().at("faults").at(1).at("began"), "never");
  EXPECT_NE(left("report.html").find("INVALID"), std::string::npos);
}

TEST_F(FirmwareResults, OfAnEarlierRunDoNotOutliveOneThatStops) {
  constexpr std::array kFiles{"summary.json", "junit.xml", "report.html", "replay.html"};
  for (const char* file : kFiles) folder_.write(std::string("out/") + file, "passed");
  start("too, many, words");  // the firmware ends at once
  EXPECT_NE(fly(), 0) << output();
  for (const char* file : kFiles) {
    EXPECT_FALSE(std::filesystem::exists(folder_.path() / "out" / file)) << file;
  }
}

}  // namespace
}  // namespace cas::test
