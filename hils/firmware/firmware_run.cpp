// SPDX-License-Identifier: BSD-3-Clause
#include "hils/firmware/firmware_run.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <iterator>
#include <memory>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "base/os/result_file.hpp"
#include "base/rpc/client.hpp"
#include "hils/firmware/firmware_bench.hpp"
#include "hils/firmware/firmware_figures.hpp"
#include "hils/firmware/firmware_pilot.hpp"
#include "hils/firmware/firmware_report.hpp"
#include "hils/firmware/firmware_verdict.hpp"
#include "hils/firmware/hitl_stream.hpp"
#include "hils/firmware/own_home.hpp"
#include "hils/measure/judgement.hpp"
#include "hils/replay/replay_command.hpp"
#include "hils/replay/replay_page.hpp"
#include "hils/replay/replay_record.hpp"
#include "hils/report/junit_report.hpp"
#include "hils/run/run_places.hpp"

namespace cas::hils {
namespace {

void print_vehicle(const FirmwareFigures& figures) {
  if (figures.height_error_m && figures.drift_m) {
    fmt::print("  error of the mean height {:.2f} m, drift {:.2f} m\n", *figures.height_error_m,
               *figures.drift_m);
  }
  if (const auto& fence = figures.fence; fence && fence->farthest_m) {
    fmt::print("  farthest from home {:.2f} m; of its fence the autopilot said '{}'\n",
               *fence->farthest_m, fence->words);
  }
  if (const auto& rms = figures.rms) {
    fmt::print("  RMS of the true position about {}: {:.3f}, {:.3f}, {:.3f} m, {:.4f} rad",
               measured_about(figures.stages), rms->x_m, rms->y_m, rms->z_m, rms->yaw_rad);
    fmt::print("; farthest {:.2f} m\n", figures.peak_error_m.value_or(0));
  } else {
    fmt::print("  the measured step was not flown to its end: it has no figures\n");
  }
  if (const auto& rms = figures.rms_estimate) {
    fmt::print("  RMS of the estimate against the truth: {:.3f}, {:.3f}, {:.3f} m, {:.4f} rad\n",
               rms->x_m, rms->y_m, rms->z_m, rms->yaw_rad);
  }
}

void print_figures(const FirmwareScenario& scenario, std::span<const FirmwareResult> vehicles,
                   std::uint64_t lost_bytes) {
  const FirmwareFigures& first = vehicles.front().figures;
  const Verdict verdict = judge_together(vehicles);
  fmt::print("{}: {}{}\n", verdict.word(), scenario.name,
             first.version.empty() ? "" : ", firmware v" + first.version);
  for (const std::string& sentence : verdict.failures) fmt::print("  - {}\n", sentence);
  for (const std::string& remark : verdict.remarks) fmt::print("  note: {}\n", remark);
  for (const std::string& warning : verdict.warnings) fmt::print("  warning: {}\n", warning);
  fmt::print("  {:.1f} s simulated at {:.2f} x real time\n", first.simulated_s,
             first.real_time_factor);
  for (const FirmwareResult& vehicle : vehicles) {
    if (vehicles.size() > 1) {
      fmt::print(" {}: {}\n", vehicle.vehicle, vehicle.verdict.word());
    }
    print_vehicle(vehicle.figures);
  }
  fmt::print(
      "  casd dropped {} packets and missed {} by their numbers; not judged, nor is the pace\n",
      first.dropped, first.lost);
  if (lost_bytes > 0) {
    fmt::print("  the serial line lost {} bytes that were not read in time\n", lost_bytes);
  }
}

/// A flight without a replay keeps its verdict.
void leave_replay(const std::filesystem::path& out) {
  try {
    const auto file = write_replay(out, tlog_record(out / "flight.tlog"));
    fmt::print("Replay:  {}\n", file.empty() ? std::string(why_no_page()) : file.string());
  } catch (const std::exception& error) {
    fmt::print(stderr, "hils: the replay was not written: {}\n", error.what());
  }
}

/// Reads the recordings of one vehicle and judges its flight.
FirmwareResult evaluate(const FirmwareScenario& scenario, const FirmwarePlaces& places,
                        std::size_t vehicle, FirmwareFigures figures) {
  const std::string& name = scenario.vehicles[vehicle];
  const std::filesystem::path truth = places.truth_csv(scenario.suffix_of(vehicle));
  add_truth(truth, figures);
  add_estimate(truth, places.flight_tlog(), figures);
  for (const auto& fault : vehicle_faults(places.simulator_stats(), name)) {
    figures.faults.push_back(fault);
  }
  figures.warnings = simulator_warnings(places.simulator_stats(), name);
  figures.never_began =
      faults_that_never_began(scenario.faults, vehicle, figures.faults, figures.flown_stages());
  if (scenario.flies_several()) {
    const auto other = home_fault(scenario, vehicle, places.flight_tlog(), figures.system);
    if (other) figures.not_flown.push_back(*other);
  }
  if (scenario.firmware.on_serial_line) {
    figures.stream = measure_hitl_stream(scenario, places, figures);
  }
  const Verdict verdict = judge(scenario, figures);
  return {.vehicle = name, .figures = std::move(figures), .verdict = verdict};
}

void write_results(const FirmwareScenario& scenario, const FirmwarePlaces& places,
                   std::span<const FirmwareResult> vehicles) {
  const auto write = [&places](const char* file, const std::string& text) {
    base::write_result({places.out, file}, text);
  };
  std::vector<std::pair<std::string, Verdict>> suites;
  for (const FirmwareResult& vehicle : vehicles) {
    suites.emplace_back("hils." + scenario.name + "." + vehicle.vehicle, vehicle.verdict);
  }
  const FirmwareResult& first = vehicles.front();
  write("summary.json", firmware_summary(scenario, vehicles).dump(2) + "\n");
  write("junit.xml", vehicles.size() > 1 ? junit_report(suites, first.figures.wall_s)
                                         : junit_report("hils." + scenario.name,
                                                        first.figures.wall_s, first.verdict));
  write("report.html", firmware_report(scenario, places, vehicles));
}

}  // namespace

int fly_firmware(const FirmwareScenario& scenario, const std::filesystem::path& out) {
  const RunDirectory sockets;
  FirmwarePlaces places{.out = out,
                        .run = out / "run",
                        .sockets = sockets.path(),
                        .command_port = sockets.command_socket()};
  std::vector<std::unique_ptr<CompanionLink>> companions;
  if (scenario.needs_companion()) {
    for (std::size_t i = 0; i < scenario.vehicles.size(); ++i) {
      companions.push_back(std::make_unique<CompanionLink>());
      places.companions.push_back(companions.back()->port());
    }
  }
  write_firmware_configs(scenario, places);
  FirmwareBench bench(scenario, places);
  const base::RunTime begin = base::steady_now();
  std::vector<FirmwareFigures> flown;
  try {
    bench.start();
    flown = pilot_firmware(scenario, places, bench, companions);
  } catch (const base::rpc::ConnectionError& error) {
    bench.supervisor().wait(std::chrono::milliseconds(500));  // a program that died is noticed
    throw RunStopped(std::string("a control connection failed: ") + error.what(), false);
  }
  bench.stop();
  const double wall_s = base::to_seconds(base::steady_now() - begin);
  std::vector<FirmwareResult> vehicles;
  for (FirmwareFigures& figures : flown) {
    figures.wall_s = wall_s;
    std::ranges::copy(bench.remarks(), std::back_inserter(figures.remarks));
    vehicles.push_back(evaluate(scenario, places, vehicles.size(), std::move(figures)));
  }
  write_results(scenario, places, vehicles);
  print_figures(scenario, vehicles, bench.lost_bytes());
  fmt::print("Results: {}\n", out.string());
  std::fflush(stdout);
  leave_replay(out);
  return judge_together(vehicles).exit_code();
}

}  // namespace cas::hils
