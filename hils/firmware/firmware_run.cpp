// SPDX-License-Identifier: BSD-3-Clause
#include "hils/firmware/firmware_run.hpp"

#include <fmt/format.h>

#include <cstdint>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "base/os/write_file.hpp"
#include "base/rpc/client.hpp"
#include "hils/firmware/firmware_bench.hpp"
#include "hils/firmware/firmware_figures.hpp"
#include "hils/firmware/firmware_pilot.hpp"
#include "hils/firmware/firmware_report.hpp"
#include "hils/firmware/firmware_verdict.hpp"
#include "hils/replay/replay_command.hpp"
#include "hils/replay/replay_page.hpp"
#include "hils/replay/replay_record.hpp"
#include "hils/report/report.hpp"
#include "hils/report/results_folder.hpp"
#include "hils/run/run_places.hpp"

namespace cas::hils {
namespace {

void print_figures(const FirmwareScenario& scenario, const FirmwareFigures& figures,
                   const Verdict& verdict, std::uint64_t lost_bytes) {
  fmt::print("{}: {}{}\n", verdict_word(verdict), scenario.name,
             figures.version.empty() ? "" : ", firmware v" + figures.version);
  for (const std::string& sentence : verdict.failures) fmt::print("  - {}\n", sentence);
  fmt::print("  {:.1f} s simulated at {:.2f} x real time; height error {:.2f} m, drift {:.2f} m\n",
             figures.simulated_s, figures.real_time_factor, figures.height_error_m,
             figures.drift_m);
  if (const auto& rms = figures.rms) {
    fmt::print("  RMS of the true position about its mean: {:.3f}, {:.3f}, {:.3f} m\n", rms->x_m,
               rms->y_m, rms->z_m);
  }
  if (const auto& rms = figures.rms_estimate) {
    fmt::print("  RMS of the estimate against the truth: {:.3f}, {:.3f}, {:.3f} m, {:.4f} rad\n",
               rms->x_m, rms->y_m, rms->z_m, rms->yaw_rad);
  }
  fmt::print(
      "  casd dropped {} packets and missed {} by their numbers; not judged, nor is the pace\n",
      figures.dropped, figures.lost);
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

}  // namespace

int fly_firmware(const FirmwareScenario& scenario, const std::filesystem::path& out) {
  remove_verdict(out);
  const RunDirectory sockets;
  const FirmwarePlaces places{.out = out,
                              .run = out / "run",
                              .sockets = sockets.path(),
                              .command_port = sockets.command_socket()};
  write_firmware_configs(scenario, places);
  FirmwareBench bench(scenario, places);
  const base::RunTime begin = base::steady_now();
  FirmwareFigures figures;
  try {
    bench.start();
    figures = pilot_firmware(scenario, places, bench.supervisor());
  } catch (const base::rpc::ConnectionError& error) {
    bench.supervisor().wait(std::chrono::milliseconds(500));  // a program that died is noticed
    throw RunStopped(std::string("a control connection failed: ") + error.what(), false);
  } catch (const RunStopped& stopped) {
    const std::string& hint = scenario.firmware.hint;
    const bool of_firmware = std::string_view(stopped.what()).starts_with("firmware ");
    if (!of_firmware || hint.empty()) throw;
    throw RunStopped(std::string(stopped.what()) + "\n" + hint, false);
  }
  bench.stop();
  figures.wall_s = base::to_seconds(base::steady_now() - begin);
  add_truth(places.truth_csv(), figures);
  add_estimate(places.truth_csv(), places.flight_tlog(), figures);
  figures.faults = vehicle_faults(places.simulator_stats(), scenario.vehicle);
  figures.never_began =
      faults_that_never_began({.bench = {}, .vehicle = scenario.faults}, 0, figures.faults);

  const Verdict verdict = judge(scenario, figures);
  base::write_file(out / "summary.json",
                   firmware_summary(scenario, figures, verdict).dump(2) + "\n",
                   base::Durability::kCache);
  base::write_file(out / "junit.xml",
                   junit_report("hils." + scenario.name, figures.wall_s, verdict),
                   base::Durability::kCache);
  base::write_file(out / "report.html", firmware_report(scenario, places, figures, verdict),
                   base::Durability::kCache);
  print_figures(scenario, figures, verdict, bench.lost_bytes());
  fmt::print("Results: {}\n", out.string());
  std::fflush(stdout);
  leave_replay(out);
  return verdict.exit_code();
}

}  // namespace cas::hils
