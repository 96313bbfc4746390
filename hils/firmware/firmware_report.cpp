// SPDX-License-Identifier: BSD-3-Clause
#include "hils/firmware/firmware_report.hpp"

#include <fmt/format.h>

#include <array>
#include <nlohmann/json.hpp>

#include "base/error.hpp"
#include "base/read_file.hpp"
#include "hils/report/figure_rows.hpp"
#include "hils/report/html_page.hpp"
#include "hils/report/run_plots.hpp"
#include "hils/report/verdict_section.hpp"

namespace cas::hils {
namespace {

using nlohmann::json;

void add_verdicts(HtmlPage& page, const FirmwareScenario& scenario,
                  std::span<const FirmwareResult> vehicles) {
  const FirmwareFigures& figures = vehicles.front().figures;
  const std::string firmware = figures.version.empty() ? "" : "firmware v" + figures.version + ", ";
  add_verdict(page, judge_together(vehicles),
              fmt::format("{}, {}{:.1f} s simulated at {:.2f} x real time", scenario.name, firmware,
                          figures.simulated_s, figures.real_time_factor));
  page.heading("What it was held to");
  for (const FirmwareResult& vehicle : vehicles) {
    add_limits(page, vehicles.size() > 1 ? "Limits: " + vehicle.vehicle : "Limits",
               vehicle.verdict);
  }
}

/// @param who  "iris1: ", or nothing
void add_flight(HtmlPage& page, const std::string& who, const FirmwareFigures& figures) {
  page.heading(who + "Flight");
  Rows steps{{"Step", "Begin, s", "End, s"}};
  for (const Stage& stage : figures.stages) {
    steps.push_back({std::string(phase_of(stage.step)),
                     fmt::format("{:.2f}", base::to_seconds(stage.begin)),
                     fmt::format("{:.2f}", base::to_seconds(stage.end))});
  }
  page.table("Steps, on simulated time", steps);
  if (!figures.faults.empty() || !figures.never_began.empty()) {
    Rows faults{{"Fault", "Begin, s", "End, s"}};
    for (const BenchFaultScript::Span& fault : figures.faults) {
      faults.push_back({fault.name, fmt::format("{:.2f}", base::to_seconds(fault.begin)),
                        fault.end ? fmt::format("{:.2f}", base::to_seconds(*fault.end)) : "-"});
    }
    for (const FaultThatNeverBegan& fault : figures.never_began) {
      faults.push_back({fault.name, "never", "-"});
    }
    page.table("Faults, as they went", faults);
  }
  if (!figures.rms && !figures.rms_estimate) {
    return page.paragraph("The measured step was not flown to its end: it has no figures.");
  }
  const Measurement motion = figures.motion();
  page.table("RMS errors in the measured step",
             {{"", "x, m", "y, m", "z, m", "yaw, rad"},
              figure_cells(motion, fmt::format("truth about {}", measured_about(figures.stages)),
                           rms_keys("rms")),
              figure_cells(motion, "estimate against truth", rms_keys("rms_estimate"))});
  if (figures.peak_error_m) {
    page.paragraph(fmt::format("Farthest from {}: {:.2f} m.", measured_about(figures.stages),
                               *figures.peak_error_m));
  }
}

void add_rates(HtmlPage& page, const FirmwareFigures& figures) {
  if (figures.rates_hz.empty()) return;
  Rows rates{{"Message", "Rate, Hz"}};
  for (const auto& [name, hz] : figures.rates_hz) {
    if (hz > 0) rates.push_back({name, fmt::format("{:.2f}", hz)});
  }
  page.table("Messages of the vehicle in the measured hold, by simulated time", rates);
}

/// An autopilot counts from where it started.
void count_from_start(std::vector<PoseSample>& truth) {
  if (truth.empty()) return;
  const Pose start = truth.front().pose;
  for (PoseSample& sample : truth) {
    sample.pose.x_m -= start.x_m;
    sample.pose.y_m -= start.y_m;
  }
}

/// Truth and estimate over time; nothing where the files cannot be read.
/// @param who  in front of their titles
void add_plots(HtmlPage& page, const FirmwarePlaces& places, const std::filesystem::path& truth_csv,
               const std::string& who, const FirmwareFigures& figures) {
  struct Axis {
    const char* title;
    double Pose::*member;
  };
  constexpr std::array kAxes{Axis{"North, m", &Pose::x_m}, Axis{"East, m", &Pose::y_m},
                             Axis{"Height, m", &Pose::z_m}, Axis{"Yaw, rad", &Pose::yaw_rad}};
  try {
    std::vector<PoseSample> truth = read_truth(truth_csv);
    count_from_start(truth);
    const std::vector<PoseSample> estimate =
        read_estimate(places.flight_tlog(), figures.system, figures.log_clock);
    for (const auto& [title, member] : kAxes) {
      Plot plot{.title = who + title, .x_label = kTimeLabel, .y_label = title};
      plot.series = {pose_series("truth", truth, member, 0),
                     pose_series("estimate", estimate, member, 0)};
      plot.series.back().dashed = true;
      for (const BenchFaultScript::Span& fault : figures.faults) {
        plot.marks.push_back(
            {.x = base::to_seconds(fault.begin), .text = fault.name, .fault = true});
      }
      page.plot(plot);
    }
  } catch (const base::ConfigError& error) {
    page.paragraph(error.what());
  }
}

void add_links(HtmlPage& page, const FirmwareFigures& figures) {
  page.heading("Links of casd");
  page.paragraph(fmt::format("casd dropped {} packets and missed {} by their numbers.",
                             figures.dropped, figures.lost));
  Rows hops{{"Way", "Packets", "50 %, us", "99 %, us", "Longest, us"}};
  for (const json& link : json::parse(figures.hops)) {
    for (const json& route : link.value("routes", json::array())) {
      const auto count = route.value("count", std::uint64_t{0});
      hops.push_back(
          {route.value("from", "") + " to " + link.value("link", ""), fmt::format("{}", count)});
      for (const char* figure : {"p50", "p99", "max"}) {
        hops.back().push_back(count > 0 ? fmt::format("{:.0f}", route.value(figure, 0.0)) : "-");
      }
    }
  }
  page.table("From one link's read to another's write", hops);
}

}  // namespace

std::string firmware_report(const FirmwareScenario& scenario, const FirmwarePlaces& places,
                            std::span<const FirmwareResult> vehicles) {
  HtmlPage page(scenario.name);
  add_verdicts(page, scenario, vehicles);
  for (std::size_t i = 0; i < vehicles.size(); ++i) {
    const FirmwareFigures& figures = vehicles[i].figures;
    const std::string who = vehicles.size() > 1 ? vehicles[i].vehicle + ": " : "";
    add_flight(page, who, figures);
    add_plots(page, places, places.truth_csv(scenario.suffix_of(i)), who, figures);
    add_rates(page, figures);
  }
  add_links(page, vehicles.front().figures);
  page.heading("Configuration");
  for (const auto& file : {scenario.file, places.simulator_config(), places.casd_config()}) {
    page.folded(file.filename().string(), base::read_file(file).value_or(""));
  }
  return page.finish();
}

}  // namespace cas::hils
