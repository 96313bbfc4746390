// SPDX-License-Identifier: BSD-3-Clause
#include "hils/measure/judgement.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <string_view>
#include <utility>

namespace cas::hils {

namespace {

using Checks = std::vector<LimitCheck>;
using Kind = LimitCheck::Kind;
using Sense = LimitCheck::Sense;
using NamedRate = std::pair<std::string_view, const RateFigures*>;

/// @param key  of one of them: scenarios take no other
const RmsAxis& axis_of(std::string_view key) {
  return *std::ranges::find(kRmsAxes, key, &RmsAxis::key);
}

LimitCheck rms_check(std::string_view what, std::string_view axis) {
  return {.what = fmt::format("RMS error of the {}, {}", what, axis),
          .unit = std::string(axis_of(axis).unit)};
}

/// Marks the check as missed, for the reason that the sentence gives.
LimitCheck missed(LimitCheck check, std::string sentence) {
  check.kept = false;
  check.sentence = std::move(sentence);
  return check;
}

/// Adds the check; `sentence` counts when its value is not within its bound. Not-a-number is not.
void add_bounded(Checks& checks, LimitCheck check, const std::string& sentence) {
  const auto margin = check.margin();
  const bool kept = margin && *margin >= 0;
  checks.push_back(kept ? std::move(check) : missed(std::move(check), sentence));
}

std::array<NamedRate, 3> named_rates(const StreamFigures& rates) {
  return {NamedRate{"HIL_SENSOR", &rates.sensor}, NamedRate{"HIL_GPS", &rates.gps},
          NamedRate{"HIL_CONTROLS", &rates.controls}};
}

void check_account(std::string_view name, const RateFigures& rate, Checks& checks) {
  const auto open = [&](const std::string& found, const std::string& why) {
    checks.push_back(missed({.kind = Kind::kValidity,
                             .what = fmt::format("account of {}", name),
                             .found = found,
                             .wanted = "closes"},
                            fmt::format("the account of {} does not close: {}", name, why)));
  };
  if (rate.duplicated > 0) {
    open(fmt::format("{} twice", rate.duplicated),
         fmt::format("{} packets arrived twice", rate.duplicated));
  }
  if (rate.unexplained > 0) {
    open(fmt::format("{} never sent", rate.unexplained),
         fmt::format("{} packets arrived that were never sent", rate.unexplained));
  }
  if (!rate.drained) {
    open("ended early", "the stream ended before its packets could arrive");
  }
  if (rate.began_late) {
    open("began late", "the stream began after the measurement");
  }
  if (!rate.closes()) return;
  checks.push_back({.kind = Kind::kValidity,
                    .what = fmt::format("account of {}", name),
                    .found = "closes",
                    .wanted = "closes"});
}

constexpr std::string_view kTooBusy = "the machine was too busy: ";
constexpr std::string_view kRemedy =
    "; end other programs, or give these real-time rights (docs/operations.md), or fly where time "
    "waits for the programs (--virtual, SITL)";

std::optional<double> milliseconds(std::optional<double> us) {
  if (us) *us *= 1e-3;
  return us;
}

/// A figure of the machine, ms or a factor, with its bound.
void add_machine(Checks& checks, LimitCheck check, const std::string& sentence) {
  check.kind = Kind::kValidity;
  if (!check.value) {
    check.found = "not measured";
    check.judged = false;
    return checks.push_back(std::move(check));
  }
  add_bounded(checks, std::move(check), std::string(kTooBusy) + sentence);
}

/// Whether simulator and programs kept up with real time, before any limit is looked at: a delay of
/// theirs is none of the vehicle's.
void check_machine(const Measurement& figures, Checks& checks) {
  const PaceFigures& pace = figures.pace;
  add_machine(checks,
              {.what = "real-time factor",
               .sense = Sense::kAtLeast,
               .value = pace.real_time_factor,
               .bound = kLeastRealTimeFactor},
              fmt::format("the simulation ran at {:.3f} of real time, and {:.2f} is needed",
                          pace.real_time_factor, kLeastRealTimeFactor));
  add_machine(checks,
              {.what = "longest stall of the simulation",
               .unit = "ms",
               .digits = 1,
               .value = pace.worst_stall_ms,
               .bound = kMostStallMs},
              fmt::format("the simulation stood still for {:.0f} ms, and {:.0f} ms is the most",
                          pace.worst_stall_ms, kMostStallMs));
  const double most_ms = most_late_ms(figures);
  add_machine(checks,
              {.what = "HIL_SENSOR sent late, 99 %",
               .unit = "ms",
               .digits = 2,
               .value = pace.late_p99_ms,
               .bound = most_ms},
              fmt::format("1 % of HIL_SENSOR left {:.1f} ms late or later, and {:g} ms is the most",
                          pace.late_p99_ms, most_ms));
  add_machine(checks,
              {.what = "handover between simulator and casd, 99 %",
               .unit = "ms",
               .digits = 2,
               .value = milliseconds(figures.handover_p99_us),
               .bound = most_ms},
              fmt::format("simulator and casd took {:.1f} ms to hand a packet over in 1 % of the "
                          "cases, and {:g} ms is the most",
                          1e-3 * figures.handover_p99_us.value_or(0), most_ms));
}

/// Lateness in the emulated controller is also the machine's: it answers a sample at once, or with
/// the next control that is due.
void check_controller(const Measurement& figures, Checks& checks) {
  if (figures.from_device) return;
  // It stamps a sample when it reads it: later than others, when it had no processor.
  const double most_late = most_late_ms(figures);
  const auto spread_ms = milliseconds(figures.reading_spread_us);
  add_machine(checks,
              {.what = "HIL_SENSOR read by the controller, 99 % less the median",
               .unit = "ms",
               .digits = 2,
               .value = spread_ms,
               .bound = most_late},
              fmt::format("1 % of HIL_SENSOR was read {:.1f} ms later than the median one, and "
                          "{:g} ms is the most",
                          spread_ms.value_or(0), most_late));
  if (figures.age_by_arrival.count == 0) return;
  const double control_hz = figures.rates.controls.nominal_hz;
  const double most_ms = most_late + (control_hz > 0 ? 1e3 / control_hz : 0);
  add_machine(checks,
              {.what = "controller's answer to a sample, 99 %",
               .unit = "ms",
               .digits = 2,
               .value = 1e-3 * figures.age_by_arrival.p99,
               .bound = most_ms},
              fmt::format("the controller took {:.1f} ms from a sample to its answer in 1 % of "
                          "the cases, and {:g} ms is the most",
                          1e-3 * figures.age_by_arrival.p99, most_ms));
}

/// The port of a controller that runs on this machine: it takes samples as fast as they come, so
/// one that is dropped there, or late, is the machine's.
void check_port(const Measurement& figures, Checks& checks) {
  if (!figures.port_gap_ms) return;
  constexpr double kMostDropped_pct = 1;  // as many may be later than one period
  const RateFigures& sensor = figures.rates.sensor;
  const double dropped_pct =
      sensor.sent > 0 ? 100.0 * static_cast<double>(sensor.lost) / static_cast<double>(sensor.sent)
                      : 0;
  add_machine(checks,
              {.what = "HIL_SENSOR dropped before the controller's port",
               .unit = "%",
               .digits = 2,
               .value = dropped_pct,
               .bound = kMostDropped_pct},
              fmt::format("{} of {} HIL_SENSOR were dropped before the controller's port, and "
                          "{:g} % is the most",
                          sensor.lost, sensor.sent, kMostDropped_pct));
  add_machine(
      checks,
      {.what = "longest gap of HIL_SENSOR at the controller's port",
       .unit = "ms",
       .digits = 1,
       .value = figures.port_gap_ms,
       .bound = kMostStallMs},
      fmt::format("no HIL_SENSOR came to the controller's port for {:.0f} ms, and {:.0f} ms "
                  "is the most",
                  *figures.port_gap_ms, kMostStallMs));
}

/// Whether the figures mean anything.
Checks validity_checks(const Measurement& figures) {
  Checks checks;
  if (!figures.virtual_clock) checks = machine_checks(figures);
  if (!figures.stages.empty() && figures.truth_samples == 0) {
    checks.push_back(missed({.kind = Kind::kValidity,
                             .what = "record of the true flight",
                             .found = "none",
                             .wanted = "there"},
                            "there is no record of the true flight"));
  } else if (figures.record_hole) {
    checks.push_back(missed({.kind = Kind::kValidity,
                             .what = "record of the true flight",
                             .found = *figures.record_hole,
                             .wanted = "there"},
                            "the record of the true flight is not whole: " + *figures.record_hole));
  }
  for (const auto& [name, rate] : named_rates(figures.rates)) {
    check_account(name, *rate, checks);
  }
  for (const PathAccount& path : figures.paths) {
    const LimitCheck check{.kind = Kind::kValidity,
                           .what = fmt::format("account of {}, hop by hop", path.message),
                           .found = path.closes() ? "closes" : "open",
                           .wanted = "closes"};
    checks.push_back(path.closes()
                         ? check
                         : missed(check, fmt::format("the account of {} does not close: {}",
                                                     path.message, path.open)));
  }
  return checks;
}

void check_rate(std::string_view name, const RateFigures& rate, const Limits& limits,
                Checks& checks) {
  if (rate.sent == 0) {
    checks.push_back(
        missed({.what = fmt::format("{} sent", name), .found = "none", .wanted = "some"},
               fmt::format("no {} was sent", name)));
    return;
  }
  if (limits.lost) {
    add_bounded(checks,
                {.what = fmt::format("{} lost", name),
                 .digits = 0,
                 .value = static_cast<double>(rate.lost),
                 .bound = static_cast<double>(*limits.lost)},
                fmt::format("{} of {} {} were lost; the limit is {}", rate.lost, rate.sent, name,
                            *limits.lost));
  }
  const double delivered =
      100.0 * static_cast<double>(rate.received) / static_cast<double>(rate.sent);
  if (limits.delivered_pct) {
    add_bounded(checks,
                {.what = fmt::format("{} delivered", name),
                 .unit = "%",
                 .digits = 3,
                 .sense = Sense::kAtLeast,
                 .value = delivered,
                 .bound = *limits.delivered_pct},
                fmt::format("{:.3f} % of {} arrived; the limit is {:g} %", delivered, name,
                            *limits.delivered_pct));
  }
  if (limits.rate_error_pct) {
    add_bounded(checks,
                {.what = fmt::format("rate of {}, error either way", name),
                 .unit = "%",
                 .value = std::abs(rate.error_pct),
                 .bound = *limits.rate_error_pct},
                fmt::format("{} arrived at {:.2f} Hz instead of {:g} Hz; the limit is {:g} %", name,
                            rate.received_hz, rate.nominal_hz, *limits.rate_error_pct));
  }
}

void check_most(std::string_view what, const char* unit, const StepResponse& response,
                std::optional<double> value, std::optional<double> limit, Checks& checks) {
  if (!limit) return;
  add_bounded(checks,
              {.what = fmt::format("{} of step '{}'", what, response.name),
               .unit = unit,
               .digits = 3,
               .value = value,
               .bound = limit,
               .found = "never"},
              value ? fmt::format("{} of step '{}' is {:.3f}; the limit is {:g}", what,
                                  response.name, *value, *limit)
                    : fmt::format("step '{}' ends before there is a {}", response.name, what));
}

void add_unjudged_response(const std::string& name, const ResponseLimits& limits, Checks& checks) {
  const auto add = [&](std::string_view what, const char* unit, std::optional<double> bound) {
    if (!bound) return;
    checks.push_back({.what = fmt::format("{} of step '{}'", what, name),
                      .unit = unit,
                      .digits = 3,
                      .bound = bound,
                      .found = "not flown",
                      .judged = false});
  };
  add("rise time", "s", limits.rise_s);
  add("overshoot", "%", limits.overshoot_pct);
  add("settling time", "s", limits.settling_s);
}

void check_responses(const std::vector<StepResponse>& responses,
                     const std::map<std::string, ResponseLimits>& limits, Checks& checks) {
  for (const auto& [name, limit] : limits) {
    const auto found = std::ranges::find(responses, name, &StepResponse::name);
    if (found == responses.end()) {
      checks.push_back(
          missed({.what = fmt::format("step '{}'", name), .found = "not flown", .wanted = "flown"},
                 fmt::format("step '{}' was not flown", name)));
      add_unjudged_response(name, limit, checks);
      continue;
    }
    checks.push_back({.what = fmt::format("step '{}'", name), .found = "flown", .wanted = "flown"});
    check_most("rise time", "s", *found, found->rise_s, limit.rise_s, checks);
    check_most("overshoot", "%", *found, found->overshoot_pct, limit.overshoot_pct, checks);
    check_most("settling time", "s", *found, found->settling_s, limit.settling_s, checks);
  }
}

void check_flown(const Measurement& figures, Checks& checks) {
  const LimitCheck check{.what = "flight",
                         .found = figures.flight_failure ? "not completed" : "completed",
                         .wanted = "completed"};
  checks.push_back(figures.flight_failure
                       ? missed(check, "the flight was not completed: " + *figures.flight_failure)
                       : check);
}

/// Those that happened in the order of time, then the kinds that did not happen.
void check_incidents(const std::vector<Incident>& incidents, const Limits& limits, Checks& checks) {
  const auto wanted = [&limits](IncidentKind kind) {
    return limits.allow.contains(kind) ? "allowed" : "none";
  };
  const auto what = [](IncidentKind kind) { return fmt::format("incident: {}", to_string(kind)); };
  for (const Incident& incident : incidents) {
    const LimitCheck check{.what = what(incident.kind),
                           .found = fmt::format("at {:.2f} s", incident.time_s),
                           .wanted = wanted(incident.kind)};
    const bool allowed = limits.allow.contains(incident.kind);
    checks.push_back(allowed ? check : missed(check, "the vehicle " + incident.what));
  }
  for (const IncidentKind kind : kIncidentKinds) {
    if (std::ranges::find(incidents, kind, &Incident::kind) != incidents.end()) continue;
    checks.push_back({.what = what(kind), .found = "none", .wanted = wanted(kind)});
  }
}

void check_latency(const DelayFigures& loop, const Limits& limits, Checks& checks) {
  if (!limits.latency_p99_us) return;
  LimitCheck check{.what = "delay of the loop, 99 %",
                   .unit = "us",
                   .digits = 0,
                   .bound = *limits.latency_p99_us,
                   .found = "not measured"};
  if (loop.count == 0) {
    checks.push_back(
        missed(std::move(check), "the loop's delay has a limit, but no packet to measure it by"));
    return;
  }
  check.value = loop.p99;
  add_bounded(checks, std::move(check),
              fmt::format("the loop takes {:.0f} us in 99 % of the cases; the limit is {:g} us",
                          loop.p99, *limits.latency_p99_us));
}

/// The measured step was not reached: there is nothing to judge, and the limits stand there all the
/// same.
void add_unjudged_rms(std::string_view what, const std::map<std::string, double>& limits,
                      Checks& checks) {
  for (const auto& [axis, limit] : limits) {
    LimitCheck check = rms_check(what, axis);
    check.bound = limit;
    check.found = "not reached";
    check.judged = false;
    checks.push_back(std::move(check));
  }
}

Checks flight_checks(const Measurement& figures, const Limits& limits) {
  Checks checks;
  check_incidents(figures.incidents, limits, checks);  // first: a crash is why it was not flown
  check_flown(figures, checks);
  for (const auto& [name, rate] : named_rates(figures.rates)) {
    check_rate(name, *rate, limits, checks);
  }
  check_latency(figures.sensor_to_control, limits, checks);
  check_responses(figures.responses, limits.responses, checks);
  check_motion({figures.rms, figures.rms_estimate, figures.peak_error_m}, limits, figures.over_hold,
               checks);
  return checks;
}

Checks fault_checks(const std::vector<FaultThatNeverBegan>& faults) {
  Checks checks;
  for (const FaultThatNeverBegan& fault : faults) {
    checks.push_back(missed({.kind = Kind::kValidity,
                             .what = fmt::format("fault '{}'", fault.name),
                             .found = "never began",
                             .wanted = "begins"},
                            fmt::format("fault '{}' never began: {}", fault.name,
                                        fault.by_time ? "the flight ended before its time"
                                                      : "its condition never came true")));
  }
  return checks;
}

void check_rms(std::string_view what, const std::optional<RmsFigures>& rms,
               const std::map<std::string, double>& limits, bool reached, Checks& checks) {
  if (limits.empty()) return;
  if (!reached) return add_unjudged_rms(what, limits, checks);
  if (!rms || rms->samples == 0) {
    checks.push_back(missed({.what = fmt::format("RMS error of the {}", what),
                             .found = "none recorded",
                             .wanted = "a record"},
                            fmt::format("there is no {} to compare with the reference", what)));
    return;
  }
  for (const auto& [axis, limit] : limits) {
    const double value = *rms.*axis_of(axis).member;
    LimitCheck check = rms_check(what, axis);
    check.value = value;
    check.bound = limit;
    add_bounded(checks, std::move(check),
                fmt::format("RMS error of the {} in {} is {:.4f}; the limit is {:g}", what, axis,
                            value, limit));
  }
}

void check_peak(std::optional<double> peak_m, std::optional<double> limit_m, bool reached,
                Checks& checks) {
  if (!limit_m) return;
  LimitCheck check{.what = "largest error of the true position",
                   .unit = "m",
                   .digits = 3,
                   .value = peak_m,
                   .bound = limit_m,
                   .found = reached ? "not measured" : "not reached",
                   .judged = reached || peak_m};
  if (!check.judged) return checks.push_back(std::move(check));
  add_bounded(checks, std::move(check),
              peak_m ? fmt::format("largest error of the true position is {:.3f} m; the limit is "
                                   "{:g} m",
                                   *peak_m, *limit_m)
                     : "there is no true position to compare with the reference");
}

/// The remedy for a busy machine follows the last sentence that says so.
std::vector<std::string> sentences_of(const Checks& checks) {
  std::vector<std::string> sentences;
  std::size_t busy = 0;  // behind the last one
  for (const LimitCheck& check : checks) {
    if (check.kept) continue;
    sentences.push_back(check.sentence);
    if (check.sentence.starts_with(kTooBusy)) busy = sentences.size();
  }
  if (busy > 0) sentences[busy - 1] += kRemedy;
  return sentences;
}

}  // namespace

void check_motion(const MotionFigures& figures, const Limits& limits, bool reached,
                  std::vector<LimitCheck>& checks) {
  check_rms("true position", figures.rms, limits.rms, reached, checks);
  check_rms("estimate", figures.rms_estimate, limits.rms_estimate, reached, checks);
  check_peak(figures.peak_error_m, limits.peak_error_m, reached, checks);
}

std::optional<std::string> unlimited_motion(const Limits& limits) {
  if (!limits.rms.empty() || limits.peak_error_m || !limits.responses.empty()) return std::nullopt;
  return "the scenario limits neither rms nor peak_error_m: how well the measured step was flown "
         "is not judged";
}

std::vector<LimitCheck> machine_checks(const Measurement& figures) {
  Checks checks;
  check_machine(figures, checks);
  check_controller(figures, checks);
  check_port(figures, checks);
  return checks;
}

double most_late_ms(const Measurement& figures) {
  constexpr double kSlowest_hz = 200;  // a stream that has no rate of its own
  const double hz = figures.rates.sensor.nominal_hz;
  return 1e3 / (hz > 0 ? hz : kSlowest_hz);
}

Verdict verdict_on(Checks validity, Checks flight,
                   const std::vector<FaultThatNeverBegan>& never_began) {
  Verdict verdict{.failures = sentences_of(validity)};
  verdict.checks = std::move(validity);
  verdict.valid = verdict.failures.empty();
  Checks faults = fault_checks(never_began);
  bool without_its_faults = false;
  if (verdict.valid) {
    verdict.failures = sentences_of(flight);
    without_its_faults = verdict.failures.empty() && !faults.empty();
    verdict.valid = !without_its_faults;
    verdict.passed = verdict.failures.empty() && verdict.valid;
    std::ranges::copy(sentences_of(faults), std::back_inserter(verdict.failures));
  }
  for (LimitCheck& check : faults) {
    check.judged = without_its_faults;
    verdict.checks.push_back(std::move(check));
  }
  for (LimitCheck& check : flight) {
    check.judged = check.judged && verdict.valid;
    verdict.checks.push_back(std::move(check));
  }
  return verdict;
}

namespace {

/// Adds the sentences that are not there yet.
void add_new(const std::vector<std::string>& sentences, std::vector<std::string>& all) {
  for (const std::string& sentence : sentences) {
    if (std::ranges::find(all, sentence) == all.end()) all.push_back(sentence);
  }
}

}  // namespace

void merge_verdict(const std::string& vehicle, const Verdict& own, Verdict& together) {
  together.valid &= own.valid;
  together.passed &= own.passed;
  for (const std::string& sentence : own.failures) {
    together.failures.push_back(vehicle + ": " + sentence);
  }
  add_new(own.remarks, together.remarks);
  add_new(own.warnings, together.warnings);
}

Verdict judge(const Measurement& figures, const Limits& limits) {
  Verdict verdict =
      verdict_on(validity_checks(figures), flight_checks(figures, limits), figures.never_began);
  if (auto remark = unlimited_motion(limits)) verdict.remarks.push_back(std::move(*remark));
  verdict.warnings = figures.warnings;
  return verdict;
}

}  // namespace cas::hils
