// SPDX-License-Identifier: BSD-3-Clause
#include <CLI/CLI.hpp>
#include <cstdio>
#include <string>

#include "base/cli/parse.hpp"
#include "base/config/config.hpp"
#include "base/config/sensor_set.hpp"
#include "base/error.hpp"
#include "base/os/program.hpp"
#include "tests/bench/estimation_bound/estimation_bound.hpp"

namespace {

using namespace cas;

void print_row(const char* name, const fcu::EstimationBound& b) {
  std::printf("%-28s %8.4f %8.4f %8.4f   %8.4f %8.4f %8.4f   %8.5f %8.5f %8.5f\n", name,
              b.position_m.x(), b.position_m.y(), b.position_m.z(), b.velocity_m_s.x(),
              b.velocity_m_s.y(), b.velocity_m_s.z(), b.attitude_rad.x(), b.attitude_rad.y(),
              b.attitude_rad.z());
}

int run(const std::string& preset, bool endless) {
  const base::ConfigNode word =
      base::ConfigNode::parse("sensors: " + preset, "command line").at("sensors");
  const fcu::SensorFigures figures = fcu::sensor_figures(base::sensor_set(word));
  std::printf("Best possible errors of a hovering vehicle, sensor set %s (1 sigma)\n\n",
              preset.c_str());
  std::printf("%-28s %26s   %26s   %26s\n", "", "position m (x y z)", "velocity m/s (x y z)",
              "attitude rad (about x y z)");
  print_row("20 s to 60 s of a flight", fcu::flight_bound(figures));
  if (endless) print_row("endless flight", fcu::steady_bound(figures));
  std::printf("\n[HILS] Table 5, SITL row: x 0.0068, y 0.0050, z 0.0449 m, yaw 0.0342 rad.\n");
  return base::kExitOk;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("Prints the best possible estimation errors for a sensor set (Riccati equation).",
               "estimation_bound");
  std::string preset = "table1";
  bool flight_only = false;
  app.add_option("preset", preset, "Set in config/sensors, or a file of that form");
  app.add_flag("--flight-only", flight_only, "Leave out the endless flight, which takes longer");
  app.set_version_flag("--version", "estimation_bound " CAS_VERSION);
  if (const auto ended = base::cli::parse(app, argc, argv, base::kExitConfig)) return *ended;
  return base::run_program("estimation_bound", "info", [&] { return run(preset, !flight_only); });
}
