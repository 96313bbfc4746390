// SPDX-License-Identifier: BSD-3-Clause
#include "hils/report/run_report.hpp"

#include <fmt/format.h>
#include <sys/utsname.h>

#include <algorithm>
#include <functional>
#include <iterator>
#include <thread>

#include <nlohmann/json.hpp>

#include "base/read_file.hpp"
#include "hils/measure/figure_table.hpp"
#include "hils/measure/hold_motion.hpp"
#include "hils/report/change_table.hpp"
#include "hils/report/experiment.hpp"
#include "hils/report/figure_rows.hpp"
#include "hils/report/number_text.hpp"
#include "hils/report/paper_figures.hpp"
#include "hils/report/plugin_section.hpp"
#include "hils/report/verdict_section.hpp"

namespace cas::hils {

namespace {

Document::Verdict verdict_of(const Measurement& figures, const Verdict& verdict) {
  const double factor = figures.pace.real_time_factor;
  const std::string pace =
      !figures.streamed
          ? fmt::format("{:.1f} s simulated at {:.2f} x real time", figures.simulated_s, factor)
      : figures.virtual_clock
          ? fmt::format("{:.1f} s simulated in {:.2f} s: {:.{}f} x real time", figures.simulated_s,
                        figures.wall_s, factor, factor < 10 ? 2 : 0)
          : fmt::format(
                "real-time factor {:.4f}, longest stall {:.1f} ms, 99 % less than {:.1f} ms late",
                factor, figures.pace.worst_stall_ms, figures.pace.late_p99_ms);
  Document::Verdict block =
      verdict_block(verdict, fmt::format("{}, {}, seed {}; {}", figures.scenario,
                                         how_it_ran(figures), figures.seed, pace));
  if (auto unjudged = unjudged_failure(figures, verdict)) {
    block.sentences.push_back(std::move(*unjudged));
  }
  return block;
}

/// Whether rows of [HILS] stand below ours.
enum class Paper { kLeftOut, kBeside };

void add_rates(Document& page, const Measurement& figures, Paper paper) {
  Rows rows{{"Message", "nominal Hz", "sent", "received", "lost", "received Hz", "error %"}};
  for (const Stream& stream : kStreams) {
    const std::string key(stream.key);
    rows.push_back(figure_cells(figures, std::string(stream.name),
                                {key + "_nominal_hz", key + "_sent", key + "_received",
                                 key + "_lost", key + "_hz", key + "_rate_error_pct"}));
  }
  page.table("Every packet followed by message and stamp, from sender to receiver", rows);

  if (paper == Paper::kLeftOut) return;
  Rows rates{{"Name", "IMU Hz", "error %", "GPS Hz", "error %", "control Hz", "error %"},
             rate_row(figures)};
  std::ranges::move(paper_rate_rows(), std::back_inserter(rates));
  page.table(
      fmt::format("Rates at the receiver over {:.1f} s of {}, beside Table 4 of [HILS]; error: how "
                  "far they fall short of the nominal rate, negative above it",
                  1e-6 * static_cast<double>(figures.window.end_usec - figures.window.begin_usec),
                  figures.over_hold ? measured_part(figures)
                                    : "flight (the measured step was not completed)"),
      rates, {Look::kPlain, Look::kQuiet, Look::kQuiet, Look::kQuiet});
}

void add_rms(Document& page, const Measurement& figures, Paper paper) {
  if (!figures.rms) return;
  const std::string name = controller_name(figures);
  Rows rows{{"Name", "X m", "Y m", "Z m", "yaw rad"}};
  std::ranges::move(rms_rows(figures, {name + ", true", name + ", its own estimate"}),
                    std::back_inserter(rows));
  const std::string title = fmt::format("RMS error of the {}", measured_part(figures));
  if (figures.firmware) {
    page.table(title, rows);
    return page.paragraph(fmt::format("The true position about {}, the estimate about the truth.",
                                      measured_about(figures)));
  }
  if (paper == Paper::kLeftOut || !measures_station_keeping(figures)) {
    return page.table(title, rows);
  }
  std::vector<Look> looks(rows.size() - 1, Look::kPlain);
  std::ranges::move(paper_rms_rows(), std::back_inserter(rows));
  looks.resize(rows.size() - 1, Look::kQuiet);
  page.table(title + ", beside Table 5 of [HILS]", rows, looks);
}

/// Figures of a delay in whole microseconds; dashes if no packet was timed.
void add_delay_cells(const DelayFigures& delay, Row& row) {
  for (const auto member :
       {&DelayFigures::p50, &DelayFigures::p90, &DelayFigures::p99, &DelayFigures::max}) {
    row.push_back(delay.count > 0 ? fixed(delay.*member, 0) : "-");
  }
}

/// Whether a delay is too negative to be printed as zero microseconds.
bool is_negative(const DelayFigures& delay) {
  constexpr double kRoundsToZero_us = -0.5;
  return std::min({delay.p50, delay.p90, delay.p99, delay.max}) < kRoundsToZero_us;
}

constexpr const char* kNegativeDelayNote =
    "A negative delay is none: the packet took less time than the moments are known to. casd notes "
    "a packet as sent when its write has returned, and the receiver may have it before that; the "
    "kernel's stamps of arrival are converted from the wall clock.";

void add_delays(Document& page, const Measurement& figures) {
  if (figures.lockstep) {
    return page.paragraph(
        "No delays: in lockstep the line is left out, and packets take no simulated time.");
  }
  page.table("Delays", delay_rows(figures));
  const bool negative = std::ranges::any_of(
      kDelays, [&](const Delay& delay) { return is_negative(figures.*delay.figures); });
  if (negative) page.paragraph(kNegativeDelayNote);
}

void add_losses(Document& page, const Measurement& figures) {
  Rows losses{{"Lost", "packets"}};
  for (const PathAccount& path : figures.paths) {
    for (const auto& [cause, count] : path.losses) {
      losses.push_back({path.message + " " + cause, fmt::format("{}", count)});
    }
  }
  if (losses.size() > 1) page.table("Losses by cause", losses);
  if (!figures.from_device) return;
  page.paragraph(
      fmt::format("The controller keeps no ledger: packets are followed from the simulator to "
                  "casd's port and back. Beyond it only gaps in its sequence numbers tell of "
                  "losses: {} packets.",
                  figures.lost_by_sequence));
}

void add_hops(Document& page, const Measurement& figures) {
  Rows rows{{"Hop", "in", "out", "median us", "90 %", "99 %", "longest", "jitter"}};
  bool negative = false;
  for (const PathAccount& path : figures.paths) {
    for (const HopFigures& hop : path.hops) {
      rows.push_back(
          {path.message + ": " + hop.name, fmt::format("{}", hop.in), fmt::format("{}", hop.out)});
      add_delay_cells(hop.delay, rows.back());
      rows.back().push_back(hop.delay.count > 1 ? fixed(hop.jitter_us, 0) : "-");
      negative = negative || is_negative(hop.delay);
    }
  }
  page.table("Each packet from hop to hop", rows);
  if (negative) page.paragraph(kNegativeDelayNote);
}

void add_faults(Document& page, const std::string& who, const Measurement& figures) {
  const Rows rows = fault_rows(figures.faults, figures.never_began);
  if (rows.size() > 1) page.table(who + "Faults", rows);
}

void add_responses(Document& page, const Measurement& figures) {
  if (figures.responses.empty()) return;
  page.table("Responses to steps of the reference", response_rows(figures));
}

void add_machine(Document& page, const Measurement& figures) {
  utsname system{};
  ::uname(&system);
  Rows rows{{"Ran with", ""}};
  rows.push_back({"CAS", std::string(CAS_VERSION)});
  rows.push_back({"Compiler", __VERSION__});
  rows.push_back({"System", fmt::format("{} {} {}, {} processors", system.sysname, system.release,
                                        system.machine, std::thread::hardware_concurrency())});
  for (const auto& [program, seconds] : figures.cpu_s) {
    rows.push_back({"Processor time of " + program,
                    fmt::format("{:.2f} s in {:.1f} s", seconds, figures.wall_s)});
  }
  page.table("Machine and versions", rows);
}

/// One row for each vehicle.
void add_overview(Document& page, const RunResult& run) {
  if (!run.has_several()) return;
  Rows rows{{"Vehicle", "verdict", "HIL_SENSOR lost", "HIL_GPS lost", "controls lost", "RMS X m",
             "Y m", "Z m"}};
  for (const VehicleResult& vehicle : run.vehicles) {
    Row row =
        figure_cells(vehicle.figures, vehicle.figures.vehicle,
                     {"sensor_lost", "gps_lost", "controls_lost", "rms_x_m", "rms_y_m", "rms_z_m"});
    row.insert(row.begin() + 1, std::string(vehicle.verdict.word()));
    rows.push_back(std::move(row));
  }
  page.table("Vehicles", rows);
}

/// casd's links in a flight of stock firmware.
void add_firmware_links(Document& page, const FirmwareRecord& firmware) {
  page.paragraph(fmt::format("casd dropped {} packets and missed {} by their numbers.",
                             firmware.dropped, firmware.lost));
  if (!firmware.rates_hz.empty()) {
    Rows rates{{"Message", "rate Hz"}};
    for (const auto& [name, hz] : firmware.rates_hz) {
      if (hz > 0) rates.push_back({name, fixed(hz, 2)});
    }
    page.table("Messages of the vehicle in the measured hold, by simulated time", rates);
  }
  Rows hops{{"Way", "packets", "median us", "99 %", "longest"}};
  for (const auto& link : nlohmann::json::parse(firmware.hops)) {
    for (const auto& route : link.value("routes", nlohmann::json::array())) {
      const auto count = route.value("count", std::uint64_t{0});
      hops.push_back(
          {route.value("from", "") + " to " + link.value("link", ""), fmt::format("{}", count)});
      for (const char* figure : {"p50", "p99", "max"}) {
        hops.back().push_back(count > 0 ? fixed(route.value(figure, 0.0), 0) : "-");
      }
    }
  }
  page.table("From one link's read to another's write", hops);
}

void add_fence(Document& page, const FenceFigures& fence) {
  if (!fence.farthest_m) return;
  page.paragraph(fmt::format("Farthest from home {:.2f} m; of its fence the autopilot said '{}'.",
                             *fence.farthest_m, fence.words));
}

/// @param who  in front of the headings: "left: ", or nothing
void add_vehicle(Document& page, const std::string& who, const Measurement& figures, Paper paper,
                 const NamedPlots& plots = {}) {
  const auto add_plots = [&](bool of_plugins) {
    for (const auto& [name, plot] : plots) {
      if (is_of_plugin(name) == of_plugins) page.add(plot);
    }
  };
  page.heading(who + "Communication");
  if (figures.streamed) {
    add_rates(page, figures, paper);
    add_delays(page, figures);
    add_losses(page, figures);
  }
  if (figures.firmware) add_firmware_links(page, *figures.firmware);
  if (figures.streamed) {
    page.heading(who + "Hops", Extent::kPage);
    add_hops(page, figures);
  }
  page.heading(who + "Flight");
  if (figures.firmware && figures.firmware->fence) add_fence(page, *figures.firmware->fence);
  add_responses(page, figures);
  add_rms(page, figures, paper);
  add_plots(false);
  if (figures.plugins.empty()) return;
  page.heading(who + "Plugins");
  add_plugin_tables(figures.plugins, page);
  add_plots(true);
}

/// In front of a vehicle's headings where there are several: "left: ".
std::string prefix_of(const RunResult& run, const VehicleResult& vehicle) {
  return run.has_several() ? vehicle.figures.vehicle + ": " : "";
}

void add_events(Document& page, const RunResult& run) {
  for (const VehicleResult& vehicle : run.vehicles) {
    add_changes(vehicle.figures.changes, prefix_of(run, vehicle), page);
    add_faults(page, prefix_of(run, vehicle), vehicle.figures);
  }
}

Paper paper_of(bool beside_paper) { return beside_paper ? Paper::kBeside : Paper::kLeftOut; }

/// Whether a check says more on a terminal than that nothing unusual happened.
bool is_told(const LimitCheck& check) { return !check.kept || check.bound.has_value(); }

}  // namespace

Document run_report(const RunResult& run, const RunReportParts& parts) {
  const Measurement whole = run.whole();
  Document page{report_title(whole)};
  page.add(verdict_of(whole, run.verdict));
  add_overview(page, run);
  add_events(page, run);
  page.heading("Limits");
  for (const VehicleResult& vehicle : run.vehicles) {
    page.add(limit_table(prefix_of(run, vehicle) + "Limits", vehicle.verdict));
  }
  if (whole.virtual_clock || !whole.streamed) {
    page.paragraph("Virtual clock: the speed of this machine does not affect the result.");
  }
  for (std::size_t i = 0; i < run.vehicles.size(); ++i) {
    const VehicleResult& vehicle = run.vehicles[i];
    add_vehicle(page, prefix_of(run, vehicle), vehicle.figures, paper_of(parts.beside_paper),
                parts.plots.empty() ? NamedPlots{} : parts.plots[i]);
  }
  page.heading("Configuration");
  add_machine(page, whole);
  for (const std::filesystem::path& file : parts.config_files) {
    page.add(Document::Folded{file.filename().string(),
                              base::read_file(file).value_or("It cannot be read.")});
  }
  return page;
}

Document run_lines(const RunResult& run, bool beside_paper) {
  const Measurement whole = run.whole();
  Document lines{report_title(whole)};
  add_overview(lines, run);
  add_events(lines, run);
  for (const VehicleResult& vehicle : run.vehicles) {
    add_vehicle(lines, prefix_of(run, vehicle), vehicle.figures, paper_of(beside_paper));
  }
  lines.heading("Limits");
  for (const VehicleResult& vehicle : run.vehicles) {
    Verdict told = vehicle.verdict;
    std::erase_if(told.checks, std::not_fn(is_told));
    Document::Table table = limit_table(prefix_of(run, vehicle) + "Limits", told);
    if (table.rows.size() > 1) lines.add(std::move(table));
  }
  lines.add(verdict_of(whole, run.verdict));
  return lines;
}

}  // namespace cas::hils
