// SPDX-License-Identifier: BSD-3-Clause
#include "hils/report/summary_json.hpp"

#include <nlohmann/json.hpp>

#include "base/time/clock.hpp"
#include "hils/measure/check_json.hpp"
#include "hils/measure/figure_json.hpp"
#include "hils/report/change_table.hpp"

namespace cas::hils {
namespace {

using OrderedJson = nlohmann::ordered_json;
using Part = Figure<Measurement>::Part;

constexpr int kSchema = 2;

OrderedJson delay_json(const DelayFigures& delay) {
  if (delay.count == 0) return nullptr;
  return {{"p50", delay.p50}, {"p90", delay.p90}, {"p99", delay.p99}, {"max", delay.max}};
}

OrderedJson path_json(const PathAccount& path) {
  OrderedJson hops = OrderedJson::array();
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

OrderedJson fault_json(const BenchFaultScript::Span& fault) {
  return {{"name", fault.name},
          {"begin_s", base::to_seconds(fault.begin)},
          {"end_s", fault.end ? OrderedJson(base::to_seconds(*fault.end)) : OrderedJson(nullptr)}};
}

OrderedJson response_json(const StepResponse& response) {
  OrderedJson json{{"step", response.name}};
  put_figures(response_table(), Figure<StepResponse>::Part::kRun, response, json);
  return json;
}

OrderedJson stage_json(const Stage& stage) {
  return {{"step", to_string(stage.step.kind)},
          {"name", phase_of(stage.step)},
          {"begin_s", base::to_seconds(stage.begin)},
          {"end_s", base::to_seconds(stage.end)}};
}

/// Steps of the flight; the last one may not have been finished.
OrderedJson stages_json(const Measurement& figures) {
  OrderedJson list = OrderedJson::array();
  for (const Stage& stage : figures.stages) list.push_back(stage_json(stage));
  if (figures.under_way) {
    list.push_back(stage_json(*figures.under_way));
    list.back()["finished"] = false;
  }
  return list;
}

/// What only stock firmware has.
void add_firmware(const Measurement& figures, OrderedJson& summary) {
  const FirmwareRecord& firmware = *figures.firmware;
  summary["firmware"] = firmware.version;
  summary["autopilot"] = firmware.autopilot;
  if (firmware.params) {
    summary["parameters"] = {{"count", firmware.params->count},
                             {"sha256", firmware.params->sha256}};
  }
  summary["rates_hz"] = firmware.rates_hz;
  if (firmware.ahrs) {
    summary["external_ahrs"] = {{"sent", firmware.ahrs->sent},
                                {"dropped", firmware.ahrs->dropped},
                                {"late", firmware.ahrs->late},
                                {"crc_errors", firmware.ahrs->crc_errors},
                                {"longest_gap_ms", firmware.ahrs->longest_gap_ms}};
  }
  if (firmware.setpoints.count > 0) {
    summary["setpoints"] = {{"count", firmware.setpoints.count},
                            {"longest_gap_s", firmware.setpoints.longest_gap_s}};
  }
  if (firmware.fence) summary["fence"] = fence_json(*firmware.fence);
  summary["dropped"] = firmware.dropped;
  summary["lost"] = firmware.lost;
  summary["messages"] = OrderedJson::parse(firmware.messages);
  summary["hops_us"] = OrderedJson::parse(firmware.hops);
}

/// By plugin and name.
OrderedJson plugins_json(const std::vector<PluginFigure>& figures) {
  OrderedJson plugins = OrderedJson::object();
  for (const PluginFigure& figure : figures) {
    OrderedJson& own = plugins[figure.plugin][figure.name];
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

/// Validity, verdict and its sentences.
void put_verdict(const Verdict& verdict, OrderedJson& summary) {
  summary["valid"] = verdict.valid;
  summary["passed"] = verdict.passed;
  summary["failures"] = verdict.failures;
  summary["failure_times_s"] = OrderedJson::array();
  for (const std::string& failure : verdict.failures) {
    const auto check = std::ranges::find(verdict.checks, failure, &LimitCheck::sentence);
    summary["failure_times_s"].push_back(
        check == verdict.checks.end() ? nullptr : number_or_null(check->time_s));
  }
  summary["remarks"] = verdict.remarks;
  summary["warnings"] = verdict.warnings;
}

/// Faults, incidents, motion and steps.
void put_flight(const Measurement& figures, OrderedJson& summary) {
  summary["faults"] = OrderedJson::array();
  for (const auto& fault : figures.faults) summary["faults"].push_back(fault_json(fault));
  for (const FaultThatNeverBegan& fault : figures.never_began) {
    summary["faults"].push_back(
        {{"name", fault.name}, {"begin_s", nullptr}, {"end_s", nullptr}, {"began", "never"}});
  }
  summary["incidents"] = OrderedJson::array();
  for (const Incident& incident : figures.incidents) {
    summary["incidents"].push_back(
        {{"kind", to_string(incident.kind)}, {"time_s", incident.time_s}, {"what", incident.what}});
  }
  put_figures(figure_table(), Part::kMotion, figures, summary);
  summary["stages"] = stages_json(figures);
}

/// What the vehicles of a run have in common.
OrderedJson run_json(const Measurement& figures, const Verdict& verdict) {
  OrderedJson summary;
  summary["schema"] = kSchema;
  summary["scenario"] = figures.scenario;
  summary["architecture"] = to_string(figures.architecture);
  summary["seed"] = figures.seed;
  put_verdict(verdict, summary);
  summary["virtual_clock"] = figures.virtual_clock;
  summary["lockstep"] = figures.lockstep;
  put_figures(figure_table(), Part::kRun, figures, summary);
  summary["cpu_s"] = OrderedJson::object();
  for (const auto& [program, seconds] : figures.cpu_s) summary["cpu_s"][program] = seconds;
  return summary;
}

OrderedJson vehicle_json(const VehicleResult& vehicle) {
  const Measurement& figures = vehicle.figures;
  OrderedJson summary{{"name", figures.vehicle}, {"system", vehicle.record.system}};
  put_verdict(vehicle.verdict, summary);
  summary["window_s"] = {{"begin", static_cast<double>(figures.window.begin_usec) * 1e-6},
                         {"end", static_cast<double>(figures.window.end_usec) * 1e-6}};
  if (figures.streamed) put_figures(figure_table(), Part::kStream, figures, summary);
  summary["from_device"] = figures.from_device;
  if (figures.from_device) summary["lost_by_sequence"] = figures.lost_by_sequence;
  summary["paths"] = OrderedJson::array();
  for (const PathAccount& path : figures.paths) summary["paths"].push_back(path_json(path));
  add_changes(figures.changes, summary);
  summary["responses"] = OrderedJson::array();
  for (const auto& response : figures.responses) {
    summary["responses"].push_back(response_json(response));
  }
  put_flight(figures, summary);
  summary["plugins"] = plugins_json(figures.plugins);
  if (figures.firmware) add_firmware(figures, summary);
  return summary;
}

}  // namespace

std::string summary_json(const RunResult& run) {
  OrderedJson summary = run_json(run.whole(), run.verdict);
  summary["vehicles"] = OrderedJson::array();
  for (const VehicleResult& vehicle : run.vehicles) {
    summary["vehicles"].push_back(vehicle_json(vehicle));
  }
  return summary.dump(2) + "\n";
}

}  // namespace cas::hils
