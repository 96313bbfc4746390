// SPDX-License-Identifier: BSD-3-Clause
#include "hils/firmware/firmware_verdict.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "hils/measure/figure_json.hpp"

namespace cas::hils {
namespace {

using nlohmann::json;

LimitCheck check(const char* what, const std::string& wanted,
                 const std::optional<std::string>& missed) {
  return {.what = what,
          .found = missed.value_or(wanted),
          .wanted = wanted,
          .kept = !missed,
          .sentence = missed.value_or("")};
}

/// Sentences in one; nullopt where there is none.
std::optional<std::string> joined(const std::vector<std::string>& sentences) {
  if (sentences.empty()) return std::nullopt;
  return fmt::format("{}", fmt::join(sentences, "; "));
}

/// A figure of the flight. One that a flight broke off before is not judged.
/// @param bounded  its name, unit, digits, sense and bound
LimitCheck check(LimitCheck bounded, std::optional<double> value, const FirmwareFigures& figures) {
  bounded.value = value;
  bounded.judged = value || !figures.flight_failure;
  const std::optional<double> margin = bounded.margin();
  bounded.kept = !bounded.judged || (margin && *margin >= 0);
  if (!margin) bounded.found = bounded.judged ? "not measured" : "not reached";
  if (bounded.kept) return bounded;
  bounded.sentence = margin ? fmt::format("{0} {1:.{4}f} {3}, limit {2:.{4}f} {3}", bounded.what,
                                          *value, *bounded.bound, bounded.unit, bounded.digits)
                            : bounded.what + " was not measured";
  return bounded;
}

/// Checks of links and messages.
void check_links(const FirmwareScenario& scenario, const FirmwareFigures& figures,
                 std::vector<LimitCheck>& checks) {
  if (scenario.hop_p99_us) {
    checks.push_back(check({.what = "slowest way through casd, 99 %",
                            .unit = "us",
                            .digits = 0,
                            .bound = scenario.hop_p99_us},
                           slowest_hop_us(json::parse(figures.hops)), figures));
  }
  for (const auto& [name, least_hz] : scenario.rates_hz) {
    std::optional<double> rate;
    if (!figures.rates_hz.empty()) {
      const auto found = figures.rates_hz.find(name);
      rate = found == figures.rates_hz.end() ? 0 : found->second;
    }
    checks.push_back(check({.what = "rate of " + name,
                            .unit = "Hz",
                            .digits = 1,
                            .sense = LimitCheck::Sense::kAtLeast,
                            .bound = least_hz},
                           rate, figures));
  }
}

/// The fence as a version of the firmware keeps it: only PX4 before v1.13 looks ahead by its way to
/// a stop; since then GF_PREDICT is off by default, and ArduPilot never does.
Geofence kept_by(const std::string& version, Geofence fence) {
  const bool turns_at_it = !version.empty() && is_at_least(version, "1.13");
  if (turns_at_it) fence.early_m = std::min(fence.early_m, fence.margin_m);
  return fence;
}

/// Of a scenario that has one.
void check_fence(const FirmwareScenario& scenario, const FirmwareFigures& figures,
                 std::vector<LimitCheck>& checks) {
  if (!scenario.fence || !figures.fence) return;
  const Geofence fence = kept_by(figures.version, *scenario.fence);
  for (LimitCheck& check : fence_checks(fence, *figures.fence, figures.flown_stages())) {
    checks.push_back(std::move(check));
  }
}

/// The fields of one vehicle in a summary.
json vehicle_json(const FirmwareFigures& figures) {
  json all{{"firmware", figures.version},
           {"rates_hz", figures.rates_hz},
           {"faults", json::array()},
           {"incidents", json::array()},
           {"stages", json::array()}};
  if (figures.params) {
    all["parameters"] = {{"count", figures.params->count}, {"sha256", figures.params->sha256}};
  }
  all["height_error_m"] = figures.height_error_m ? json(*figures.height_error_m) : json();
  all["drift_m"] = figures.drift_m ? json(*figures.drift_m) : json();
  put_figures(figure_table(), Figure<Measurement>::Part::kMotion, figures.motion(), all);
  if (figures.stream) {
    put_figures(figure_table(), Figure<Measurement>::Part::kStream, *figures.stream, all);
  }
  if (figures.setpoints.count > 0) {
    all["setpoints"] = {{"count", figures.setpoints.count},
                        {"longest_gap_s", figures.setpoints.longest_gap_s}};
  }
  if (figures.fence) all["fence"] = fence_json(*figures.fence);
  for (const BenchFaultScript::Span& fault : figures.faults) {
    json& entry = all["faults"].emplace_back();
    entry = {{"name", fault.name}, {"begin_s", base::to_seconds(fault.begin)}};
    if (fault.end) entry["end_s"] = base::to_seconds(*fault.end);
  }
  for (const FaultThatNeverBegan& fault : figures.never_began) {
    all["faults"].push_back(
        {{"name", fault.name}, {"begin_s", nullptr}, {"end_s", nullptr}, {"began", "never"}});
  }
  for (const Incident& incident : figures.incidents) {
    all["incidents"].push_back(
        {{"kind", to_string(incident.kind)}, {"time_s", incident.time_s}, {"what", incident.what}});
  }
  for (const Stage& stage : figures.flown_stages()) {
    all["stages"].push_back({{"step", to_string(stage.step.kind)},
                             {"begin_s", base::to_seconds(stage.begin)},
                             {"end_s", base::to_seconds(stage.end)}});
  }
  if (figures.under_way) all["stages"].back()["finished"] = false;
  return all;
}

/// Whether the vehicle stayed on the ground for no reason that the flight shows: its autopilot
/// disarms it after a time, or somebody did. After an incident or a fault it has failed.
bool has_no_verdict(const FirmwareFigures& figures) {
  return figures.disarmed_on_ground && figures.incidents.empty() && figures.faults.empty() &&
         !figures.unwatched;
}

LimitCheck disarmed_unhurt(const FirmwareFigures& figures) {
  return {
      .kind = LimitCheck::Kind::kValidity,
      .what = "the vehicle armed until it takes off",
      .found = "disarmed",
      .wanted = "armed",
      .kept = false,
      .sentence = figures.flight_failure.value_or("") +
                  "; it stands upright and unhurt, no fault has struck, and hils does not arm it "
                  "again: the flight has no verdict"};
}

}  // namespace

Verdict judge(const FirmwareScenario& scenario, const FirmwareFigures& figures) {
  std::vector<LimitCheck> checks;
  std::vector<LimitCheck> validity;
  if (figures.stream) validity = machine_checks(*figures.stream);
  const bool held =
      !figures.flight_failure ||
      std::ranges::any_of(figures.stages, [](const Stage& stage) { return stage.step.measure; });
  if (has_no_verdict(figures)) validity.push_back(disarmed_unhurt(figures));
  checks.push_back(check("flight", "every step was done", figures.flight_failure));
  if (scenario.height_error_m) {
    checks.push_back(check({.what = "error of the mean height",
                            .unit = "m",
                            .digits = 2,
                            .bound = scenario.height_error_m},
                           figures.height_error_m, figures));
  }
  if (scenario.drift_m) {
    checks.push_back(check({.what = "drift", .unit = "m", .digits = 2, .bound = scenario.drift_m},
                           figures.drift_m, figures));
  }
  check_figures(figures.motion(), scenario.limits.figures, held, checks);
  check_links(scenario, figures, checks);
  check_fence(scenario, figures, checks);
  checks.push_back(
      check("steps by the true flight", "as the vehicle says", joined(figures.not_flown)));
  std::vector<std::string> incidents;
  for (const Incident& incident : figures.incidents) {
    incidents.push_back((incidents.empty() ? "the vehicle " : "it ") + incident.what);
  }
  checks.push_back(check("incidents", "none", joined(incidents)));
  std::optional<std::string> unrecorded = figures.unwatched;
  if (unrecorded) unrecorded->insert(0, "the true flight was not recorded: ");
  checks.push_back(check("true flight", "recorded", unrecorded));
  Verdict verdict = verdict_on(std::move(validity), std::move(checks), figures.never_began);
  verdict.remarks = figures.remarks;
  verdict.warnings = figures.warnings;
  if (auto remark = unlimited_motion(scenario.limits)) {
    verdict.remarks.push_back(std::move(*remark));
  }
  return verdict;
}

Verdict judge_together(std::span<const FirmwareResult> vehicles) {
  if (vehicles.size() == 1) return vehicles.front().verdict;
  Verdict together{.valid = true, .passed = true, .failures = {}};
  for (const FirmwareResult& vehicle : vehicles) {
    merge_verdict(vehicle.vehicle, vehicle.verdict, together);
  }
  return together;
}

json firmware_summary(const FirmwareScenario& scenario, std::span<const FirmwareResult> vehicles) {
  const FirmwareFigures& first = vehicles.front().figures;
  const Verdict together = judge_together(vehicles);
  json all{{"schema", 2},
           {"scenario", scenario.name},
           {"valid", together.valid},
           {"passed", together.passed},
           {"failures", together.failures},
           {"remarks", together.remarks},
           {"warnings", together.warnings},
           {"simulated_s", first.simulated_s},
           {"wall_s", first.wall_s},
           {"real_time_factor", first.real_time_factor},
           {"dropped", first.dropped},
           {"lost", first.lost},
           {"messages", json::parse(first.messages)},
           {"hops_us", json::parse(first.hops)}};
  if (vehicles.size() == 1) {
    all.update(vehicle_json(first));
    return all;
  }
  for (const FirmwareResult& vehicle : vehicles) {
    json& entry = all["vehicles"].emplace_back(vehicle_json(vehicle.figures));
    entry["name"] = vehicle.vehicle;
    entry["system"] = vehicle.figures.system;
    entry["passed"] = vehicle.verdict.passed;
    entry["failures"] = vehicle.verdict.failures;
  }
  return all;
}

}  // namespace cas::hils
