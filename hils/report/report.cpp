// SPDX-License-Identifier: BSD-3-Clause
#include "hils/report/report.hpp"

#include <fmt/format.h>

#include <cmath>
#include <cstddef>
#include <nlohmann/json.hpp>

#include "base/time/clock.hpp"
#include "hils/report/change_table.hpp"
#include "hils/report/delay_note.hpp"
#include "hils/report/experiment.hpp"
#include "hils/report/number_text.hpp"
#include "hils/report/paper_figures.hpp"
#include "hils/report/plot.hpp"
#include "hils/report/plugin_section.hpp"

namespace cas::hils {

namespace {

std::string verdict_text(const Measurement& figures, const Verdict& verdict) {
  std::string text = fmt::format("{}: {}, {}, seed {}\n", verdict_word(verdict), figures.scenario,
                                 title_of(figures.architecture), figures.seed);
  for (const std::string& sentence : verdict.failures) text += "  - " + sentence + "\n";
  text += figures.virtual_clock
              ? fmt::format("  {:.1f} s simulated in {:.2f} s: {:.{}f} x real time\n",
                            figures.simulated_s, figures.wall_s, figures.pace.real_time_factor,
                            figures.pace.real_time_factor < 10 ? 2 : 0)
              : fmt::format(
                    "  real-time factor {:.4f}, longest stall {:.1f} ms, 99 % less than {:.1f} ms "
                    "late\n",
                    figures.pace.real_time_factor, figures.pace.worst_stall_ms,
                    figures.pace.late_p99_ms);
  return text;
}

/// A rate at the receiver and how far it falls short of the nominal one.
struct RateCells {
  double hz;
  double error_pct;
};

RateCells cells_of(const RateFigures& rate) { return {rate.received_hz, rate.error_pct}; }

std::string rate_row(std::string_view name, RateCells sensor, RateCells gps, RateCells controls) {
  return fmt::format("{:<16} {:>10} {:>9} {:>9} {:>9} {:>11} {:>9}\n", name, fixed(sensor.hz, 4),
                     fixed(sensor.error_pct, 4), fixed(gps.hz, 4), fixed(gps.error_pct, 4),
                     fixed(controls.hz, 4), fixed(controls.error_pct, 4));
}

std::string rate_table(const Measurement& figures) {
  const StreamFigures& rates = figures.rates;
  std::string text = fmt::format(
      "\nTable 4. Rates at the receiver over {:.1f} s of {}\n",
      static_cast<double>(figures.window.end_usec - figures.window.begin_usec) * 1e-6,
      figures.over_hold ? measured_part(figures) : "flight (the measured step was not reached)");
  text += fmt::format("{:<16} {:>20} {:>19} {:>21}\n", "",
                      fmt::format("IMU {:g} Hz", rates.sensor.nominal_hz),
                      fmt::format("GPS {:g} Hz", rates.gps.nominal_hz),
                      fmt::format("Control {:g} Hz", rates.controls.nominal_hz));
  text += fmt::format("{:<16} {:>10} {:>9} {:>9} {:>9} {:>11} {:>9}\n", "Name", "Hz", "error %",
                      "Hz", "error %", "Hz", "error %");
  text += rate_row(title_of(figures.architecture), cells_of(rates.sensor), cells_of(rates.gps),
                   cells_of(rates.controls));
  for (const PaperRates& row : kPaperTable4) {
    text += rate_row(fmt::format("[HILS] {}", row.name), {row.sensor_hz, row.sensor_error_pct},
                     {row.gps_hz, row.gps_error_pct}, {row.controls_hz, row.controls_error_pct});
  }
  text += fmt::format("{:<16} {:>20} {:>19} {:>21}\n", "sent / lost",
                      fmt::format("{} / {}", rates.sensor.sent, rates.sensor.lost),
                      fmt::format("{} / {}", rates.gps.sent, rates.gps.lost),
                      fmt::format("{} / {}", rates.controls.sent, rates.controls.lost));
  return text;
}

std::string rms_row(std::string_view name, const RmsFigures& rms) {
  return fmt::format("{:<16} {:>8} {:>8} {:>8} {:>10}\n", name, fixed(rms.x_m, 4),
                     fixed(rms.y_m, 4), fixed(rms.z_m, 4), fixed(rms.yaw_rad, 4));
}

std::string rms_table(const Measurement& figures) {
  if (!figures.rms) return {};
  const bool as_table_5 = measures_station_keeping(figures);
  std::string text = fmt::format("\n{}RMS error of the {}\n", as_table_5 ? "Table 5. " : "",
                                 measured_part(figures));
  text += fmt::format("{:<16} {:>8} {:>8} {:>8} {:>10}\n", "Name", "X m", "Y m", "Z m", "Yaw rad");
  const std::string name = title_of(figures.architecture);
  text += rms_row(name + " true", *figures.rms);
  if (figures.rms_estimate) text += rms_row(name + " estimate", *figures.rms_estimate);
  if (!as_table_5) return text;
  for (const PaperRms& row : kPaperTable5) {
    text += rms_row(fmt::format("[HILS] {}", row.name),
                    {.x_m = row.x_m, .y_m = row.y_m, .z_m = row.z_m, .yaw_rad = row.yaw_rad});
  }
  return text;
}

std::string delay_row(std::string_view name, const DelayFigures& delay) {
  return fmt::format("{:<34} {:>9} {:>9} {:>9}\n", name, fixed(delay.p50, 0), fixed(delay.p99, 0),
                     fixed(delay.max, 0));
}

std::string delay_table(const Measurement& figures) {
  std::string text =
      fmt::format("\n{:<34} {:>9} {:>9} {:>9}\n", "Delay, us", "median", "99 %", "longest");
  text += delay_row("HIL_SENSOR out -> control back", figures.sensor_to_control);
  text += delay_row("HIL_SENSOR to the controller", figures.sensor_uplink);
  text += delay_row("control to the simulator", figures.controls_downlink);
  text += delay_row("age of the sample at use (made)", figures.age_by_stamp);
  text += delay_row("age of the sample at use (arrived)", figures.age_by_arrival);
  if (has_negative_delay(figures)) text += fmt::format("{}\n", kNegativeDelayNote);
  return text;
}

std::string loss_lines(const Measurement& figures) {
  std::string text;
  for (const PathAccount& path : figures.paths) {
    for (const auto& [cause, count] : path.losses) {
      text += fmt::format("{} {} lost {}\n", count, path.message, cause);
    }
  }
  if (figures.from_device) {
    text += fmt::format(
        "The controller keeps no ledger: packets are followed from the simulator to casd's port "
        "and back.\nBeyond it only gaps in its sequence numbers tell of losses: {} packets.\n",
        figures.lost_by_sequence);
  }
  return text.empty() ? text : "\n" + text;
}

std::string response_table(const Measurement& figures) {
  if (figures.responses.empty()) return {};
  std::string text = fmt::format("\n{:<16} {:>8} {:>8} {:>12} {:>12} {:>16}\n", "Step", "size m",
                                 "rise s", "overshoot %", "settling s", "int. error m s");
  for (const StepResponse& response : figures.responses) {
    text += fmt::format("{:<16} {:>8} {:>8} {:>12} {:>12} {:>16}\n", response.name,
                        fixed(response.size, 2), fixed(response.rise_s, 2),
                        fixed(response.overshoot_pct, 1), fixed(response.settling_s, 2),
                        fixed(response.integrated_error, 3));
  }
  return text;
}

/// What plugins report: the value, or the range of a series.
std::string plugin_table(const Measurement& figures) {
  if (figures.plugins.empty()) return {};
  std::string text = fmt::format("\n{:<48} {}\n", "Plugin", "reports");
  for (const PluginFigure& figure : figures.plugins) {
    text += fmt::format("{:<48} {}{}{}\n", figure.plugin + ": " + figure.name, value_text(figure),
                        figure.unit.empty() ? "" : " ", figure.unit);
  }
  return text;
}

std::string figures_text(const Measurement& figures) {
  return changes_text(figures.changes) + rate_table(figures) + response_table(figures) +
         rms_table(figures) + delay_table(figures) + loss_lines(figures) + plugin_table(figures);
}

/// One line for each vehicle.
std::string overview_table(const RunResult& run) {
  std::string text = fmt::format("\n{:<24} {:>8} {:>20} {:>8} {:>8} {:>8}\n", "Vehicle", "verdict",
                                 "lost IMU/GPS/control", "RMS X m", "Y m", "Z m");
  for (const VehicleResult& vehicle : run.vehicles) {
    const StreamFigures& rates = vehicle.figures.rates;
    const std::optional<RmsFigures>& rms = vehicle.figures.rms;
    text += fmt::format(
        "{:<24} {:>8} {:>20} {:>8} {:>8} {:>8}\n", vehicle.figures.vehicle,
        verdict_word(vehicle.verdict),
        fmt::format("{} / {} / {}", rates.sensor.lost, rates.gps.lost, rates.controls.lost),
        rms_text(rms, &RmsFigures::x_m), rms_text(rms, &RmsFigures::y_m),
        rms_text(rms, &RmsFigures::z_m));
  }
  return text;
}

using Json = nlohmann::ordered_json;

constexpr int kSchema = 1;

Json rate_json(const RateFigures& rate) {
  return {{"nominal_hz", rate.nominal_hz},   {"sent", rate.sent},
          {"received", rate.received},       {"lost", rate.lost},
          {"received_hz", rate.received_hz}, {"error_pct", rate.error_pct}};
}

Json delay_json(const DelayFigures& delay) {
  if (delay.count == 0) return nullptr;
  return {{"p50", delay.p50}, {"p90", delay.p90}, {"p99", delay.p99}, {"max", delay.max}};
}

Json rms_json(const std::optional<RmsFigures>& rms) {
  if (!rms) return nullptr;
  return {{"x_m", rms->x_m}, {"y_m", rms->y_m}, {"z_m", rms->z_m}, {"yaw_rad", rms->yaw_rad}};
}

template <class Number>
Json optional_json(const std::optional<Number>& value) {
  return value ? Json(*value) : Json(nullptr);
}

Json path_json(const PathAccount& path) {
  Json hops = Json::array();
  for (const HopFigures& hop : path.hops) {
    hops.push_back({{"hop", hop.name},
                    {"in", hop.in},
                    {"out", hop.out},
                    {"latency_us", delay_json(hop.delay)},
                    {"jitter_us", hop.jitter_us}});
  }
  return {{"message", path.message}, {"sent", path.sent},     {"received", path.received},
          {"closes", path.closes()}, {"losses", path.losses}, {"hops", std::move(hops)}};
}

Json fault_json(const BenchFaultScript::Span& fault) {
  return {{"name", fault.name},
          {"begin_s", base::to_seconds(fault.begin)},
          {"end_s", fault.end ? Json(base::to_seconds(*fault.end)) : Json(nullptr)}};
}

Json response_json(const StepResponse& response) {
  return {{"step", response.name},
          {"size_m", response.size},
          {"rise_s", optional_json(response.rise_s)},
          {"overshoot_pct", response.overshoot_pct},
          {"settling_s", optional_json(response.settling_s)},
          {"integrated_error_m_s", response.integrated_error}};
}

Json stage_json(const Stage& stage) {
  return {{"step", to_string(stage.step.kind)},
          {"name", phase_of(stage.step)},
          {"begin_s", base::to_seconds(stage.begin)},
          {"end_s", base::to_seconds(stage.end)}};
}

/// Steps of the flight; the last one may not have been finished.
Json stages_json(const Measurement& figures) {
  Json list = Json::array();
  for (const Stage& stage : figures.stages) list.push_back(stage_json(stage));
  if (figures.under_way) {
    list.push_back(stage_json(*figures.under_way));
    list.back()["finished"] = false;
  }
  return list;
}

/// By plugin and name.
Json plugins_json(const std::vector<PluginFigure>& figures) {
  Json plugins = Json::object();
  for (const PluginFigure& figure : figures) {
    Json& own = plugins[figure.plugin][figure.name];
    own["unit"] = figure.unit;
    if (figure.series) {
      own["samples"] = figure.samples;
      own["min"] = optional_json(figure.least);
      own["max"] = optional_json(figure.greatest);
      own["mean"] = optional_json(figure.mean);
      own["last"] = optional_json(figure.last);
    } else {
      own["value"] = optional_json(figure.last);
    }
    if (figure.not_finite > 0) own["not_finite"] = figure.not_finite;
  }
  return plugins;
}

/// Fields that every run has.
Json run_json(const Measurement& figures, const Verdict& verdict) {
  Json summary;
  summary["schema"] = kSchema;
  summary["scenario"] = figures.scenario;
  summary["architecture"] = to_string(figures.architecture);
  summary["seed"] = figures.seed;
  summary["valid"] = verdict.valid;
  summary["passed"] = verdict.passed;
  summary["failures"] = verdict.failures;
  summary["virtual_clock"] = figures.virtual_clock;
  summary["real_time_factor"] = figures.pace.real_time_factor;
  summary["worst_stall_ms"] = figures.pace.worst_stall_ms;
  summary["late_p99_ms"] = figures.pace.late_p99_ms;
  summary["handover_p99_us"] = figures.handover_p99_us;
  summary["reading_spread_us"] = figures.reading_spread_us;
  summary["cpu_pressure"] = figures.cpu_pressure ? Json(*figures.cpu_pressure) : Json(nullptr);
  summary["simulated_s"] = figures.simulated_s;
  summary["wall_s"] = figures.wall_s;
  summary["cpu_s"] = Json::object();
  for (const auto& [program, seconds] : figures.cpu_s) summary["cpu_s"][program] = seconds;
  return summary;
}

/// Appends the figures of one vehicle.
void add_figures(const Measurement& figures, Json& summary) {
  summary["window_s"] = {{"begin", static_cast<double>(figures.window.begin_usec) * 1e-6},
                         {"end", static_cast<double>(figures.window.end_usec) * 1e-6}};
  summary["rates"] = {{"HIL_SENSOR", rate_json(figures.rates.sensor)},
                      {"HIL_GPS", rate_json(figures.rates.gps)},
                      {"HIL_CONTROLS", rate_json(figures.rates.controls)}};
  summary["latency_us"] = {{"sensor_to_control", delay_json(figures.sensor_to_control)},
                           {"sensor_uplink", delay_json(figures.sensor_uplink)},
                           {"controls_downlink", delay_json(figures.controls_downlink)}};
  summary["age_at_use_us"] = {{"by_stamp", delay_json(figures.age_by_stamp)},
                              {"by_arrival", delay_json(figures.age_by_arrival)}};
  summary["meter_hz"] = {{"HIL_SENSOR", figures.meter.sensor_hz},
                         {"HIL_GPS", figures.meter.gps_hz},
                         {"HIL_CONTROLS", figures.meter.controls_hz}};
  summary["from_device"] = figures.from_device;
  if (figures.from_device) summary["lost_by_sequence"] = figures.lost_by_sequence;
  summary["paths"] = Json::array();
  for (const PathAccount& path : figures.paths) summary["paths"].push_back(path_json(path));
  summary["faults"] = Json::array();
  for (const auto& fault : figures.faults) summary["faults"].push_back(fault_json(fault));
  for (const FaultThatNeverBegan& fault : figures.never_began) {
    summary["faults"].push_back(
        {{"name", fault.name}, {"begin_s", nullptr}, {"end_s", nullptr}, {"began", "never"}});
  }
  summary["incidents"] = Json::array();
  for (const Incident& incident : figures.incidents) {
    summary["incidents"].push_back(
        {{"kind", to_string(incident.kind)}, {"time_s", incident.time_s}, {"what", incident.what}});
  }
  add_changes(figures.changes, summary);
  summary["responses"] = Json::array();
  for (const auto& response : figures.responses) {
    summary["responses"].push_back(response_json(response));
  }
  summary["rms"] = rms_json(figures.rms);
  summary["rms_estimate"] = rms_json(figures.rms_estimate);
  summary["stages"] = stages_json(figures);
  summary["plugins"] = plugins_json(figures.plugins);
}

Json vehicle_json(const Measurement& figures, const Verdict& verdict) {
  Json summary = run_json(figures, verdict);
  add_figures(figures, summary);
  return summary;
}

/// Counts of a suite, and its cases.
struct JunitCases {
  std::string suite;
  std::string text{};
  std::size_t tests = 0, failures = 0, errors = 0, skipped = 0;

  /// @param outcome  an element within the case; empty: it passed
  void add(const std::string& name, double time_s, const std::string& outcome) {
    ++tests;
    text += fmt::format("  <testcase classname=\"{}\" name=\"{}\" time=\"{:.3f}\"", suite,
                        escape_xml(name), time_s);
    text += outcome.empty() ? "/>\n" : ">" + outcome + "</testcase>\n";
  }
  /// @param invalid  the run does not count: an error, no failure
  void add_missed(const std::string& name, double time_s, bool invalid,
                  const std::string& sentence) {
    ++(invalid ? errors : failures);
    add(name, time_s,
        fmt::format("<{} message=\"{}\"/>", invalid ? "error" : "failure", escape_xml(sentence)));
  }
};

/// A case for the verdict and one for each thing that a run is held to, under the same names
/// whatever comes out.
std::string junit_suite(const std::string& name, double wall_s, const Verdict& verdict) {
  JunitCases cases{.suite = escape_xml(name)};
  if (verdict.passed) {
    cases.add("verdict", wall_s, "");
  } else {
    cases.add_missed("verdict", wall_s, !verdict.valid,
                     fmt::format("{}", fmt::join(verdict.failures, "; ")));
  }
  for (const LimitCheck& check : verdict.checks) {
    if (!check.judged) {
      ++cases.skipped;
      cases.add(check.what, 0, "<skipped/>");
    } else if (check.kept) {
      cases.add(check.what, 0, "");
    } else {
      cases.add_missed(check.what, 0, check.kind == LimitCheck::Kind::kValidity, check.sentence);
    }
  }
  return fmt::format(
      "<testsuite name=\"{}\" tests=\"{}\" failures=\"{}\" errors=\"{}\" skipped=\"{}\" "
      "time=\"{:.3f}\">\n{}</testsuite>\n",
      cases.suite, cases.tests, cases.failures, cases.errors, cases.skipped, wall_s, cases.text);
}

/// @param who  behind the name of the suite: ".left", or nothing
std::string junit_suite(const Measurement& figures, const Verdict& verdict,
                        const std::string& who) {
  return junit_suite(
      fmt::format("hils.{}.{}{}", figures.scenario, to_string(figures.architecture), who),
      figures.wall_s, verdict);
}

constexpr const char* kXmlHead = "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n";

}  // namespace

std::string_view verdict_word(const Verdict& verdict) {
  if (!verdict.valid) return "INVALID";
  return verdict.passed ? "PASSED" : "FAILED";
}

std::string rms_text(const std::optional<RmsFigures>& rms, double RmsFigures::*axis) {
  return rms ? fixed((*rms).*axis, 4) : "-";
}

std::string text_report(const Measurement& figures, const Verdict& verdict) {
  return verdict_text(figures, verdict) + figures_text(figures);
}

std::string text_report(const RunResult& run) {
  if (!run.has_several()) return text_report(run.vehicles.front().figures, run.verdict);
  std::string text = verdict_text(run.whole(), run.verdict) + overview_table(run);
  for (const VehicleResult& vehicle : run.vehicles) {
    text += fmt::format("\n== {} ==\n", vehicle.figures.vehicle) + figures_text(vehicle.figures);
  }
  return text;
}

std::string summary_json(const Measurement& figures, const Verdict& verdict) {
  return vehicle_json(figures, verdict).dump(2) + "\n";
}

std::string summary_json(const RunResult& run) {
  if (!run.has_several()) return summary_json(run.vehicles.front().figures, run.verdict);
  Json summary = run_json(run.whole(), run.verdict);
  summary["vehicles"] = Json::array();
  for (const VehicleResult& vehicle : run.vehicles) {
    Json entry{{"name", vehicle.figures.vehicle}};
    entry.update(vehicle_json(vehicle.figures, vehicle.verdict));
    summary["vehicles"].push_back(std::move(entry));
  }
  return summary.dump(2) + "\n";
}

std::string junit_report(const RunResult& run) {
  std::string text = kXmlHead;
  if (!run.has_several()) return text + junit_suite(run.vehicles.front().figures, run.verdict, "");
  text += "<testsuites>\n";
  for (const VehicleResult& vehicle : run.vehicles) {
    text += junit_suite(vehicle.figures, vehicle.verdict, "." + vehicle.figures.vehicle);
  }
  return text + "</testsuites>\n";
}

std::string junit_report(const std::string& name, double wall_s, const Verdict& verdict) {
  return kXmlHead + junit_suite(name, wall_s, verdict);
}

std::string junit_report(const std::vector<std::pair<std::string, Verdict>>& suites,
                         double wall_s) {
  std::string text = std::string(kXmlHead) + "<testsuites>\n";
  for (const auto& [name, verdict] : suites) text += junit_suite(name, wall_s, verdict);
  return text + "</testsuites>\n";
}

}  // namespace cas::hils
