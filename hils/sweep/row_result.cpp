// SPDX-License-Identifier: BSD-3-Clause
#include "hils/sweep/row_result.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "base/text.hpp"
#include "hils/flight/flight_step.hpp"
#include "hils/measure/figure_table.hpp"
#include "hils/measure/strike_fields.hpp"
#include "hils/sweep/run_table.hpp"
#include "hils/sweep/sweep_folder.hpp"

namespace cas::hils {

namespace {

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

/// Collects figures under their names, so that both stand in one place.
struct Figures {
  void add(const std::string& name, double value) {
    names.push_back(prefix + name);
    values.push_back(std::isfinite(value) ? value : kNone);
  }
  void add(const std::string& name, const std::optional<double>& value) {
    add(name, value.value_or(kNone));
  }

  std::string prefix{};
  std::vector<std::string> names{};
  std::vector<double> values{};
};

/// Smallest margin over all limits of the flight, % of the limit; negative beyond it.
double least_margin_pct(const Verdict& verdict) {
  double least = kNone;
  for (const LimitCheck& check : verdict.checks) {
    if (check.kind != LimitCheck::Kind::kFlight || !check.judged || !check.margin()) continue;
    if (!(std::abs(*check.bound) > 0)) continue;
    const double margin = *check.margin() / std::abs(*check.bound) * 100;
    if (!(margin >= least)) least = margin;
  }
  return least;
}

std::optional<Incident> first_incident(const Scenario& scenario, const RunResult& run) {
  std::optional<Incident> first;
  for (std::size_t i = 0; i < run.vehicles.size(); ++i) {
    for (const Incident& incident : run.vehicles[i].figures.incidents) {
      if (scenario.limits_of(i).allow.contains(incident.kind)) continue;
      if (!first || incident.time_s < first->time_s) first = incident;
    }
  }
  return first;
}

bool was_completed(const RunResult& run) {
  return std::ranges::all_of(
      run.vehicles, [](const VehicleResult& vehicle) { return !vehicle.figures.flight_failure; });
}

/// The step that the first vehicle with an unfinished flight was in; empty: none, or before one.
std::string unfinished_step(const RunResult& run) {
  for (const VehicleResult& vehicle : run.vehicles) {
    if (!vehicle.figures.flight_failure) continue;
    const std::optional<Stage>& step = vehicle.figures.under_way;
    return step ? std::string(phase_of(step->step)) : std::string();
  }
  return "";
}

/// Names of the steps whose response a vehicle's flight measures.
std::vector<std::string> response_names(const Scenario& scenario) {
  std::vector<std::string> names;
  for (const FlightStep& step : scenario.steps) {
    if (step.trajectory.shape == fcu::PatternShape::kSteps) names.emplace_back(phase_of(step));
  }
  return names;
}

void add_vehicle(const Scenario& scenario, const Measurement& measured, Figures& figures) {
  for (const Figure<Measurement>& row : figure_table()) {
    if (row.part != Figure<Measurement>::Part::kRun) figures.add(row.key, row.get(measured));
  }
  for (const std::string& name : response_names(scenario)) {
    const auto found = std::ranges::find(measured.responses, name, &StepResponse::name);
    const bool has = found != measured.responses.end();
    for (const Figure<StepResponse>& row : response_table()) {
      figures.add(name + "_" + row.key, has ? row.get(*found) : std::nullopt);
    }
  }
}

/// The figures of a run; with a run without vehicles, their names alone mean something.
Figures collect(const Scenario& scenario, const RunResult* run) {
  Figures figures;
  const std::optional<Incident> incident =
      run != nullptr ? first_incident(scenario, *run) : std::nullopt;
  double up = kNone;
  double margin = kNone;
  if (run != nullptr && run->verdict.valid) up = was_completed(*run) && !incident ? 1 : 0;
  if (run != nullptr) {
    for (const VehicleResult& vehicle : run->vehicles) {
      if (!vehicle.figures.over_hold) continue;  // the measured step was not flown
      const double own = least_margin_pct(vehicle.verdict);
      if (!(own >= margin) && std::isfinite(own)) margin = own;
    }
  }
  figures.add("up", up);
  figures.add("crash_s", incident ? incident->time_s : kNone);
  figures.add("least_margin_pct", margin);
  figures.add("simulated_s", run != nullptr ? run->vehicles.front().figures.simulated_s : kNone);
  for (std::size_t i = 0; i < scenario.vehicles.size(); ++i) {
    if (scenario.flies_several()) figures.prefix = scenario.vehicles[i].name + ".";
    add_vehicle(scenario, run != nullptr ? run->vehicles[i].figures : Measurement{}, figures);
  }
  return figures;
}

std::string number_field(double value) {
  return std::isfinite(value) ? fmt::format("{}", value == 0 ? 0.0 : value) : std::string();
}

nlohmann::json strike_json(const StrikeResponse& strike) {
  nlohmann::json json;
  for_each_strike_field(StrikeOutput::kJournal, [&](const auto& field) {
    json[field.key] = field_json<nlohmann::json>(strike, field);
  });
  return json;
}

StrikeResponse parse_strike(const nlohmann::json& json) {
  StrikeResponse strike;
  for_each_strike_field(StrikeOutput::kJournal,
                        [&](const auto& field) { read_field(json.at(field.key), field, strike); });
  return strike;
}

/// On one line, so that a line of a file is a row, and harmless to a terminal.
std::string one_line(std::string text) {
  std::ranges::replace_if(
      text, [](unsigned char c) { return std::iscntrl(c) != 0; }, ' ');
  return text;
}

}  // namespace

bool is_judged(RowOutcome outcome) {
  return outcome == RowOutcome::kPassed || outcome == RowOutcome::kFailed ||
         outcome == RowOutcome::kStopped;
}

std::vector<std::string> figure_names(const Scenario& scenario) {
  return collect(scenario, nullptr).names;
}

RowResult row_of(const Scenario& scenario, const RunResult& run) {
  RowResult result;
  result.outcome = !run.verdict.valid   ? RowOutcome::kInvalid
                   : run.verdict.passed ? RowOutcome::kPassed
                                        : RowOutcome::kFailed;
  result.cause = base::joined(run.verdict.failures, "; ", one_line);
  if (const auto incident = first_incident(scenario, run)) {
    result.incident = to_string(incident->kind);
  }
  result.unfinished = one_line(unfinished_step(run));
  result.figures = collect(scenario, &run).values;
  result.strike = run.vehicles.front().figures.strike;
  for (const std::string& warning : run.verdict.warnings) {
    result.warnings.push_back(one_line(without_folder(warning, scenario.file.parent_path())));
  }
  return result;
}

FlightWarnings warnings_of(const std::vector<RowResult>& results) {
  FlightWarnings warnings;
  for (const RowResult& result : results) {
    if (result.row != 0) warnings.add(result.warnings);
  }
  return warnings;
}

RowResult row_without_figures(RowOutcome outcome, std::string cause) {
  RowResult result{.outcome = outcome, .cause = one_line(std::move(cause))};
  if (outcome == RowOutcome::kStopped) result.figures = {0.0};  // it did not stay up
  return result;
}

std::string journal_line(const RowResult& result) {
  nlohmann::json json;
  json["row"] = result.row;
  json["outcome"] = to_string(result.outcome);
  json["cause"] = result.cause;
  json["incident"] = result.incident;
  json["version"] = result.version;
  json["truth_sha256"] = result.truth_sha256;
  json["figures"] = nlohmann::json::array();
  for (const double value : result.figures) {
    json["figures"].push_back(std::isfinite(value) ? nlohmann::json(value)
                                                   : nlohmann::json(nullptr));
  }
  json["machine"] = {{"wall_s", result.machine.wall_s},
                     {"cpu_s", result.machine.cpu_s},
                     {"max_rss_mib", result.machine.max_rss_mib},
                     {"host", result.machine.host}};
  if (!result.run_sha256.empty()) json["run_sha256"] = result.run_sha256;
  if (!result.unfinished.empty()) json["unfinished"] = result.unfinished;
  if (!result.key.empty()) json["key"] = result.key;
  if (result.strike) json["strike"] = strike_json(*result.strike);
  if (!result.warnings.empty()) json["warnings"] = result.warnings;
  return json.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace) + "\n";
}

std::optional<RowResult> parse_journal_line(std::string_view line) {
  const nlohmann::json json = nlohmann::json::parse(line, nullptr, false);
  if (!json.is_object()) return std::nullopt;
  try {
    RowResult result;
    result.row = json.at("row").get<std::size_t>();
    const auto outcome = kRowOutcomes.find(json.at("outcome").get<std::string>());
    if (!outcome || result.row == 0) return std::nullopt;
    result.outcome = *outcome;
    result.cause = json.at("cause").get<std::string>();
    result.incident = json.at("incident").get<std::string>();
    result.version = json.at("version").get<std::string>();
    result.truth_sha256 = json.at("truth_sha256").get<std::string>();
    for (const nlohmann::json& value : json.at("figures")) {
      result.figures.push_back(value.is_null() ? kNone : value.get<double>());
    }
    const nlohmann::json& machine = json.at("machine");
    result.machine = {.wall_s = machine.at("wall_s").get<double>(),
                      .cpu_s = machine.at("cpu_s").get<double>(),
                      .max_rss_mib = machine.at("max_rss_mib").get<double>(),
                      .host = machine.at("host").get<std::string>()};
    result.run_sha256 = json.value("run_sha256", "");
    result.unfinished = json.value("unfinished", "");
    result.key = json.value("key", "");
    if (json.contains("strike")) result.strike = parse_strike(json.at("strike"));
    result.warnings = json.value("warnings", result.warnings);
    return result;
  } catch (const nlohmann::json::exception&) {
    return std::nullopt;
  }
}

std::string result_headings(const std::vector<std::string>& figures) {
  std::string text = ",outcome";
  for (const std::string& name : figures) text += "," + csv_field(name);
  return text + ",incident,cause,version,truth_sha256";
}

std::string result_fields(const RowResult& result, std::size_t figures) {
  std::string text = fmt::format(",{}", to_string(result.outcome));
  for (std::size_t i = 0; i < figures; ++i) {
    text += "," + number_field(i < result.figures.size() ? result.figures[i] : kNone);
  }
  for (const std::string* field :
       {&result.incident, &result.cause, &result.version, &result.truth_sha256}) {
    text += "," + csv_field(*field);
  }
  return text;
}

std::string machine_headings() { return "row,wall_s,cpu_s,max_rss_mib,host"; }

std::string machine_line(const RowResult& result) {
  return fmt::format("{},{:.3f},{:.3f},{:.1f},{}", result.row, result.machine.wall_s,
                     result.machine.cpu_s, result.machine.max_rss_mib,
                     csv_field(result.machine.host));
}

}  // namespace cas::hils
