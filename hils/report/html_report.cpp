// SPDX-License-Identifier: BSD-3-Clause
#include "hils/report/html_report.hpp"

#include <fmt/format.h>
#include <sys/utsname.h>

#include <algorithm>
#include <iterator>
#include <thread>

#include "base/read_file.hpp"
#include "hils/measure/figure_table.hpp"
#include "hils/report/change_table.hpp"
#include "hils/report/delay_note.hpp"
#include "hils/report/experiment.hpp"
#include "hils/report/figure_rows.hpp"
#include "hils/report/html_page.hpp"
#include "hils/report/number_text.hpp"
#include "hils/report/paper_figures.hpp"
#include "hils/report/plugin_section.hpp"
#include "hils/report/verdict_section.hpp"

namespace cas::hils {

namespace {

void add_verdict(HtmlPage& page, const Measurement& figures, const Verdict& verdict) {
  const std::string pace =
      figures.virtual_clock
          ? fmt::format("{:.1f} s on the virtual clock in {:.2f} s", figures.simulated_s,
                        figures.wall_s)
          : fmt::format(
                "real-time factor {:.4f}, longest stall {:.1f} ms, 99 % less than {:.1f} ms late",
                figures.pace.real_time_factor, figures.pace.worst_stall_ms,
                figures.pace.late_p99_ms);
  add_verdict(page, verdict,
              fmt::format("{}, {}, seed {}; {}", figures.scenario, how_it_ran(figures),
                          figures.seed, pace));
  if (const auto unjudged = unjudged_failure(figures, verdict)) page.paragraph(*unjudged);
}

/// The limits and validity checks of a vehicle, before all figures.
void add_limits(HtmlPage& page, const std::string& who, const VehicleResult& vehicle) {
  add_limits(page, who + "Limits", vehicle.verdict);
  if (vehicle.figures.virtual_clock) {
    page.paragraph("Nothing is asked of the machine: time was computed, not waited for.");
  }
}

void add_rates(HtmlPage& page, const Measurement& figures) {
  Rows rows{{"Message", "nominal Hz", "sent", "received", "lost", "received Hz", "error %"}};
  for (const Stream& stream : kStreams) {
    const std::string key(stream.key);
    rows.push_back(figure_cells(figures, std::string(stream.name),
                                {key + "_nominal_hz", key + "_sent", key + "_received",
                                 key + "_lost", key + "_hz", key + "_rate_error_pct"}));
  }
  page.table("Every packet followed by message and stamp, from sender to receiver", rows);

  Rows paper{{"Name", "IMU Hz", "error %", "GPS Hz", "error %", "control Hz", "error %"}};
  std::ranges::move(rate_rows(figures), std::back_inserter(paper));
  const std::vector<HtmlPage::Row> looks{HtmlPage::Row::kPlain, HtmlPage::Row::kQuiet,
                                         HtmlPage::Row::kQuiet, HtmlPage::Row::kQuiet};
  page.table(
      "Rates at the receiver, beside Table 4 of [HILS]; error: how far they fall short of the "
      "nominal rate, negative above it",
      paper, looks);
}

void add_rms(HtmlPage& page, const Measurement& figures) {
  if (!figures.rms) return;
  const std::string name = title_of(figures.architecture);
  Rows rows{{"Name", "X m", "Y m", "Z m", "yaw rad"}};
  std::ranges::move(rms_rows(figures, {name + ", true", name + ", its own estimate"}),
                    std::back_inserter(rows));
  const std::string title = fmt::format("RMS error of the {}", measured_part(figures));
  if (!measures_station_keeping(figures)) return page.table(title, rows);
  std::vector<HtmlPage::Row> looks(rows.size() - 1, HtmlPage::Row::kPlain);
  std::fill_n(looks.rbegin(), kPaperTable5.size(), HtmlPage::Row::kQuiet);
  page.table(title + ", beside Table 5 of [HILS]", rows, looks);
}

/// Figures of a delay in whole microseconds; dashes if no packet was timed.
void add_delay_cells(const DelayFigures& delay, std::vector<std::string>& row) {
  for (const auto member :
       {&DelayFigures::p50, &DelayFigures::p90, &DelayFigures::p99, &DelayFigures::max}) {
    row.push_back(delay.count > 0 ? fixed(delay.*member, 0) : "-");
  }
}

void add_hops(HtmlPage& page, const Measurement& figures) {
  Rows rows{{"Hop", "in", "out", "median us", "90 %", "99 %", "longest", "jitter"}};
  for (const PathAccount& path : figures.paths) {
    for (const HopFigures& hop : path.hops) {
      rows.push_back(
          {path.message + ": " + hop.name, fmt::format("{}", hop.in), fmt::format("{}", hop.out)});
      add_delay_cells(hop.delay, rows.back());
      rows.back().push_back(hop.delay.count > 1 ? fixed(hop.jitter_us, 0) : "-");
    }
  }
  page.table("Each packet from hop to hop", rows);
  if (has_negative_delay(figures) || has_negative_hop(figures)) {
    page.paragraph(kNegativeDelayNote);
  }
  Rows losses{{"Lost", "packets"}};
  for (const PathAccount& path : figures.paths) {
    for (const auto& [cause, count] : path.losses) {
      losses.push_back({path.message + " " + cause, fmt::format("{}", count)});
    }
  }
  if (losses.size() > 1) page.table("Losses by cause", losses);
  if (figures.from_device) {
    page.paragraph(
        fmt::format("The controller keeps no ledger: packets are followed from the simulator to "
                    "casd's port and "
                    "back. Beyond it only gaps in its sequence numbers tell of losses: {} packets.",
                    figures.lost_by_sequence));
  }
}

void add_faults(HtmlPage& page, const Measurement& figures) {
  Rows rows{{"Fault", "begin s", "end s"}};
  std::ranges::move(fault_rows(figures), std::back_inserter(rows));
  if (rows.size() > 1) page.table("Faults", rows);
}

void add_changes(HtmlPage& page, const std::string& who, const FlightChanges& changes) {
  if (changes.from_outside()) page.paragraph(who + std::string(kOutsideNote));
  if (!changes.parameters.empty()) {
    page.table(who + "Changed in flight", parameter_rows(changes));
  }
  if (!changes.acts.empty()) page.table(who + "Commands from outside", act_rows(changes));
}

void add_responses(HtmlPage& page, const Measurement& figures) {
  if (figures.responses.empty()) return;
  page.table("Responses to steps of the reference", response_rows(figures));
}

void add_machine(HtmlPage& page, const Measurement& figures) {
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
void add_overview(HtmlPage& page, const RunResult& run) {
  if (!run.has_several()) return;
  Rows rows{{"Vehicle", "verdict", "HIL_SENSOR lost", "HIL_GPS lost", "controls lost", "RMS X m",
             "Y m", "Z m"}};
  for (const VehicleResult& vehicle : run.vehicles) {
    std::vector<std::string> row =
        figure_cells(vehicle.figures, vehicle.figures.vehicle,
                     {"sensor_lost", "gps_lost", "controls_lost", "rms_x_m", "rms_y_m", "rms_z_m"});
    row.insert(row.begin() + 1, title_of(vehicle.verdict));
    rows.push_back(std::move(row));
  }
  page.table("Vehicles", rows);
}

/// @param who  in front of the headings: "left: ", or nothing
void add_vehicle(HtmlPage& page, const std::string& who, const Measurement& figures,
                 const NamedPlots& plots) {
  page.heading(who + "Communication");
  add_rates(page, figures);
  page.table("Delays", delay_rows(figures));
  add_hops(page, figures);
  page.heading(who + "Flight");
  add_responses(page, figures);
  add_rms(page, figures);
  add_faults(page, figures);
  for (const auto& [name, plot] : plots) {
    if (!is_of_plugin(name)) page.plot(plot);
  }
  if (figures.plugins.empty()) return;
  page.heading(who + "Plugins");
  add_plugin_tables(page, figures.plugins);
  for (const auto& [name, plot] : plots) {
    if (is_of_plugin(name)) page.plot(plot);
  }
}

}  // namespace

std::string html_report(const RunResult& run, const std::vector<NamedPlots>& plots,
                        const std::vector<std::filesystem::path>& config_files) {
  const Measurement whole = run.whole();
  HtmlPage page(report_title(whole));
  add_verdict(page, whole, run.verdict);
  add_overview(page, run);
  for (const VehicleResult& vehicle : run.vehicles) {
    const std::string who = run.has_several() ? vehicle.figures.vehicle + ": " : "";
    add_changes(page, who, vehicle.figures.changes);
    add_limits(page, who, vehicle);
  }
  for (std::size_t i = 0; i < run.vehicles.size(); ++i) {
    const Measurement& figures = run.vehicles[i].figures;
    add_vehicle(page, run.has_several() ? figures.vehicle + ": " : "", figures, plots[i]);
  }
  page.heading("Configuration");
  add_machine(page, whole);
  for (const std::filesystem::path& file : config_files) {
    page.folded(file.filename().string(), base::read_file(file).value_or(""));
  }
  return page.finish();
}

}  // namespace cas::hils
