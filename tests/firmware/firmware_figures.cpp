// SPDX-License-Identifier: BSD-3-Clause
// Prints lockstep round trips a second and how even HIL_SENSOR arrives. firmware_figures [SECONDS]
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>

#include "tests/firmware/ardupilot_peer.hpp"
#include "tests/firmware/px4_hitl_fixture.hpp"
#include "tests/firmware/px4_sitl_peer.hpp"
#include "tests/firmware/running_simulation.hpp"

namespace cas::test {
namespace {

constexpr const char* kFreePort = "local: '127.0.0.1:0'";

double seconds_since(base::RunTime start) { return base::to_seconds(base::steady_now() - start); }

/// One HIL_ACTUATOR_CONTROLS for each HIL_SENSOR, with a controller that flies.
void lockstep_over_tcp(double seconds) {
  RunningSimulation simulation("px4_sitl.yaml", "mavlink_interface", kFreePort);
  Px4SitlPeer peer(simulation.port(), {}, {.hover = std::chrono::hours(1)});
  peer.run_until([&] { return peer.pilot().stage() == Pilot::Stage::kHover; });
  const base::RunTime start = base::steady_now();
  const base::RunTime sim_start = peer.px4().clock();
  const std::uint64_t first = peer.px4().answers();
  peer.run_until([&] { return seconds_since(start) > seconds || peer.pilot().ended(); });
  const double wall_s = seconds_since(start);
  std::printf("PX4 SITL, TCP lockstep: %.0f round trips/s, %.1f x real time\n",
              static_cast<double>(peer.px4().answers() - first) / wall_s,
              base::to_seconds(peer.px4().clock() - sim_start) / wall_s);
}

void lockstep_over_json(double seconds) {
  RunningSimulation simulation("ardupilot.yaml", "ardupilot_json", kFreePort);
  ArdupilotPeer peer(simulation.port(), {}, {.hover = std::chrono::hours(1)});
  peer.run_until([&] { return peer.pilot().stage() == Pilot::Stage::kHover; });
  const base::RunTime start = base::steady_now();
  const std::uint32_t first = peer.ardupilot().frame_count();
  peer.run_until([&] { return seconds_since(start) > seconds; });
  const double hz = (peer.ardupilot().frame_count() - first) / seconds_since(start);
  std::printf("ArduPilot SITL, UDP lockstep: %.0f packets/s, %.1f x real time\n", hz, hz / 1200);
}

/// How even HIL_SENSOR arrives at the end of the serial line.
void evenness(const char* name, unsigned baud, double seconds) {
  Px4HitlFixture hitl({.mode = Px4Mode::kHitl}, baud);
  hitl.run_until([&] { return hitl.px4().samples() > 500; });
  hitl.arrivals().clear();
  const base::RunTime start = base::steady_now();
  hitl.run_until([&] { return seconds_since(start) > seconds; }, base::from_seconds(seconds + 10));
  std::vector<double> deviation_us;
  const auto& at = hitl.arrivals();
  double shortest_us = 1e9;
  for (std::size_t i = 1; i < at.size(); ++i) {
    constexpr double kNominal_us = 4000;
    const double interval_us = base::to_seconds(at[i] - at[i - 1]) * 1e6;
    shortest_us = std::min(shortest_us, interval_us);
    deviation_us.push_back(std::abs(interval_us - kNominal_us));
  }
  std::sort(deviation_us.begin(), deviation_us.end());
  const auto quantile = [&](double q) {
    return deviation_us[static_cast<std::size_t>(q * static_cast<double>(deviation_us.size() - 1))];
  };
  std::printf(
      "HIL_SENSOR on %s: %.2f Hz, deviation from 4 ms p50 %.0f us, p99 %.0f us, max %.0f us; "
      "shortest interval %.0f us\n",
      name, static_cast<double>(at.size()) / seconds, quantile(0.5), quantile(0.99),
      deviation_us.back(), shortest_us);
}

}  // namespace
}  // namespace cas::test

int main(int argc, char** argv) {
  const double seconds = argc > 1 ? std::atof(argv[1]) : 20;
  cas::test::lockstep_over_tcp(seconds);
  cas::test::lockstep_over_json(seconds);
  cas::test::evenness("921600 baud", 921600, seconds);
  cas::test::evenness("USB", 0, seconds);
  return 0;
}
