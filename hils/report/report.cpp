// SPDX-License-Identifier: BSD-3-Clause
#include "hils/report/report.hpp"

#include <fmt/format.h>

#include <array>
#include <cstddef>
#include <nlohmann/json.hpp>
#include <span>

#include "base/text.hpp"
#include "base/time/clock.hpp"
#include "hils/measure/check_json.hpp"
#include "hils/report/change_table.hpp"
#include "hils/report/delay_note.hpp"
#include "hils/report/experiment.hpp"
#include "hils/report/figure_rows.hpp"
#include "hils/report/junit.hpp"
#include "hils/report/number_text.hpp"
#include "hils/report/plugin_section.hpp"

namespace cas::hils {

namespace {

std::string verdict_text(const Measurement& figures, const Verdict& verdict) {
  std::string text = fmt::format("{}: {}, {}, seed {}\n", verdict_word(verdict), figures.scenario,
                                 how_it_ran(figures), figures.seed);
  for (const std::string& sentence : verdict.failures) text += "  - " + sentence + "\n";
  if (const auto unjudged = unjudged_failure(figures, verdict)) text += "  " + *unjudged + "\n";
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

/// A table of fixed widths: the first column left-aligned, the others right-aligned.
std::string lines(const Rows& rows, std::span<const int> widths) {
  std::string text;
  for (const std::vector<std::string>& row : rows) {
    text += fmt::format("{:<{}}", row.front(), widths.front());
    for (std::size_t i = 1; i < row.size(); ++i) {
      text += fmt::format(" {:>{}}", row[i], widths[i]);
    }
    text += "\n";
  }
  return text;
}

std::string rate_table(const Measurement& figures) {
  constexpr std::array kColumns{16, 10, 9, 9, 9, 11, 9};
  constexpr std::array kPairs{16, 20, 19, 21};
  const StreamFigures& rates = figures.rates;
  const auto over = [](const char* name, const RateFigures& rate) {
    return fmt::format("{} {:g} Hz", name, rate.nominal_hz);
  };
  const auto losses = [](const RateFigures& rate) {
    return fmt::format("{} / {}", rate.sent, rate.lost);
  };
  return fmt::format(
             "\nTable 4. Rates at the receiver over {:.1f} s of {}\n",
             static_cast<double>(figures.window.end_usec - figures.window.begin_usec) * 1e-6,
             figures.over_hold ? measured_part(figures)
                               : "flight (the measured step was not completed)") +
         lines({{"", over("IMU", rates.sensor), over("GPS", rates.gps),
                 over("Control", rates.controls)}},
               kPairs) +
         lines({{"Name", "Hz", "error %", "Hz", "error %", "Hz", "error %"}}, kColumns) +
         lines(rate_rows(figures), kColumns) +
         lines({{"sent / lost", losses(rates.sensor), losses(rates.gps), losses(rates.controls)}},
               kPairs);
}

std::string rms_table(const Measurement& figures) {
  if (!figures.rms) return {};
  constexpr std::array kColumns{16, 8, 8, 8, 10};
  const std::string name = title_of(figures.architecture);
  return fmt::format("\n{}RMS error of the {}\n",
                     measures_station_keeping(figures) ? "Table 5. " : "", measured_part(figures)) +
         lines({{"Name", "X m", "Y m", "Z m", "Yaw rad"}}, kColumns) +
         lines(rms_rows(figures, {name + " true", name + " estimate"}), kColumns);
}

std::string delay_table(const Measurement& figures) {
  if (figures.lockstep) {
    return "\nNo delays: in lockstep the line is left out, and packets take no simulated time.\n";
  }
  Rows rows{{"Delay, us", "median", "99 %", "longest"}};
  for (const auto& [which, name, _] : kDelayRows) {
    const DelayFigures& delay = figures.*which;
    rows.push_back({name, fixed(delay.p50, 0), fixed(delay.p99, 0), fixed(delay.max, 0)});
  }
  std::string text = "\n" + lines(rows, std::array{34, 9, 9, 9});
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
  constexpr std::array kColumns{16, 8, 8, 12, 12, 16};
  return "\n" +
         lines({{"Step", "size m", "rise s", "overshoot %", "settling s", "int. error m s"}},
               kColumns) +
         lines(response_rows(figures), kColumns);
}

/// Figures of the plugins: the value, or the range of a series.
std::string plugin_table(const Measurement& figures) {
  if (figures.plugins.empty()) return {};
  Rows rows{{"Plugin", "reports"}};
  for (const PluginFigure& figure : figures.plugins) {
    rows.push_back({figure.plugin + ": " + figure.name,
                    value_text(figure) + (figure.unit.empty() ? "" : " ") + figure.unit});
  }
  return "\n" + lines(rows, std::array{48, 0});
}

std::string figures_text(const Measurement& figures) {
  return changes_text(figures.changes) + rate_table(figures) + response_table(figures) +
         rms_table(figures) + delay_table(figures) + loss_lines(figures) + plugin_table(figures);
}

/// One line for each vehicle.
std::string overview_table(const RunResult& run) {
  Rows rows{{"Vehicle", "verdict", "lost IMU/GPS/control", "RMS X m", "Y m", "Z m"}};
  for (const VehicleResult& vehicle : run.vehicles) {
    const auto& [sensor, gps, controls] = vehicle.figures.rates;
    const std::vector<std::string> rms = rms_cells(vehicle.figures.rms);
    rows.push_back({vehicle.figures.vehicle, std::string(verdict_word(vehicle.verdict)),
                    fmt::format("{} / {} / {}", sensor.lost, gps.lost, controls.lost), rms[0],
                    rms[1], rms[2]});
  }
  return "\n" + lines(rows, std::array{24, 8, 20, 8, 8, 8});
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
  Json all;
  for (const RmsAxis& axis : kRmsAxes) all[std::string(axis.key)] = *rms.*axis.member;
  return all;
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
          {"rise_s", number_or_null(response.rise_s)},
          {"overshoot_pct", response.overshoot_pct},
          {"settling_s", number_or_null(response.settling_s)},
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
      own["min"] = number_or_null(figure.least);
      own["max"] = number_or_null(figure.greatest);
      own["mean"] = number_or_null(figure.mean);
      own["last"] = number_or_null(figure.last);
    } else {
      own["value"] = number_or_null(figure.last);
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
  summary["lockstep"] = figures.lockstep;
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

/// A case for the verdict and one for each limit and validity check, under the same names whatever
/// the result.
std::string junit_suite(const std::string& name, double wall_s, const Verdict& verdict) {
  using Outcome = JunitSuite::Outcome;
  JunitSuite suite(name);
  suite.add("verdict",
            verdict.passed  ? Outcome::kPassed
            : verdict.valid ? Outcome::kFailed
                            : Outcome::kError,
            base::joined(verdict.failures, "; "), wall_s);
  for (const LimitCheck& check : verdict.checks) {
    const bool decides_validity = check.kind == LimitCheck::Kind::kValidity;
    suite.add(check.what,
              !check.judged      ? Outcome::kSkipped
              : check.kept       ? Outcome::kPassed
              : decides_validity ? Outcome::kError
                                 : Outcome::kFailed,
              check.judged ? check.sentence : "", 0);
  }
  return suite.element(wall_s);
}

/// @param who  appended to the name of the suite: ".left", or nothing
std::string junit_suite(const Measurement& figures, const Verdict& verdict,
                        const std::string& who) {
  return junit_suite(
      fmt::format("hils.{}.{}{}", figures.scenario, to_string(figures.architecture), who),
      figures.wall_s, verdict);
}

}  // namespace

std::string_view verdict_word(const Verdict& verdict) {
  if (!verdict.valid) return "INVALID";
  return verdict.passed ? "PASSED" : "FAILED";
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
