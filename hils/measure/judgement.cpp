// SPDX-License-Identifier: BSD-3-Clause
#include "hils/measure/judgement.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <string_view>
#include <utility>

#include "hils/measure/figure_table.hpp"

namespace cas::hils {

namespace {

using Checks = std::vector<LimitCheck>;
using Kind = LimitCheck::Kind;
using Sense = LimitCheck::Sense;

/// Marks the check as missed, for the reason that the sentence gives.
LimitCheck missed(LimitCheck check, std::string sentence) {
  check.kept = false;
  check.sentence = std::move(sentence);
  return check;
}

/// Adds the check; `sentence` counts when it is not kept.
void add_judged(Checks& checks, LimitCheck check, bool kept, const std::string& sentence) {
  checks.push_back(kept ? std::move(check) : missed(std::move(check), sentence));
}

/// Adds the check; `sentence` counts when its value is not within its bound. Not-a-number is not.
void add_bounded(Checks& checks, LimitCheck check, const std::string& sentence) {
  const auto margin = check.margin();
  const bool kept = margin && *margin >= 0;
  add_judged(checks, std::move(check), kept, sentence);
}

/// Whether the run counts: a check without a bound.
LimitCheck validity(std::string what, std::string found, std::string wanted) {
  return {.kind = Kind::kValidity,
          .what = std::move(what),
          .found = std::move(found),
          .wanted = std::move(wanted)};
}

/// The check of a figure that has a bound: at most, or at least where up is better.
template <class Of>
LimitCheck bounded(const Figure<Of>& row, const std::string& of_what, double bound) {
  return {.what = row.title + of_what,
          .unit = row.unit,
          .digits = row.digits,
          .sense = row.better == Better::kUp ? Sense::kAtLeast : Sense::kAtMost,
          .bound = bound};
}

/// The same with its value. @param key  of figure_table()
LimitCheck bounded(const Measurement& figures, std::string_view key, double bound) {
  const Figure<Measurement>& row = figure_row(key);
  LimitCheck check = bounded(row, "", bound);
  check.value = row.get(figures);
  return check;
}

void check_account(std::string_view name, const RateFigures& rate, Checks& checks) {
  const std::string what = fmt::format("account of {}", name);
  const auto open = [&](const std::string& found, const std::string& why) {
    checks.push_back(missed(validity(what, found, "closes"),
                            fmt::format("the {} does not close: {}", what, why)));
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
  if (rate.closes()) checks.push_back(validity(what, "closes", "closes"));
}

constexpr std::string_view kRemedy =
    "; end other programs, or give these real-time rights (docs/use/operations.md), or fly where "
    "time "
    "waits for the programs (--virtual, SITL)";

/// A condition that the machine must meet.
void add_machine(Checks& checks, LimitCheck check, const std::string& sentence) {
  check.kind = Kind::kValidity;
  check.about = LimitCheck::About::kMachine;
  if (!check.value) {
    check.found = "not measured";
    check.judged = false;
    return checks.push_back(std::move(check));
  }
  add_bounded(checks, std::move(check), "the machine was too busy: " + sentence);
}

void check_pace(const Measurement& figures, Checks& checks) {
  add_machine(checks, bounded(figures, "real_time_factor", kLeastRealTimeFactor),
              fmt::format("the simulation ran at {:.3f} of real time, and {:.2f} is needed",
                          figures.pace.real_time_factor, kLeastRealTimeFactor));
}

/// Whether simulator and programs kept up with real time, before any limit is looked at: a delay of
/// theirs is none of the vehicle's.
void check_machine(const Measurement& figures, Checks& checks) {
  const PaceFigures& pace = figures.pace;
  check_pace(figures, checks);
  add_machine(
      checks, bounded(figures, "worst_stall_ms", kMostStallMs),
      fmt::format(
          "the simulation fell behind by {:.0f} ms within a second, and {:.0f} ms is the most",
          pace.worst_stall_ms, kMostStallMs));
  const double most_ms = most_late_ms(figures);
  add_machine(checks, bounded(figures, "late_p99_ms", most_ms),
              fmt::format("1 % of HIL_SENSOR left {:.1f} ms late or later, and {:g} ms is the most",
                          pace.late_p99_ms, most_ms));
  add_machine(checks, bounded(figures, "handover_p99_us", 1e3 * most_ms),
              fmt::format("simulator and casd took {:.1f} ms to hand a packet over in 1 % of the "
                          "cases, and {:g} ms is the most",
                          1e-3 * figures.handover_p99_us.value_or(0), most_ms));
}

/// Lateness in the emulated controller is also the machine's: it answers a sample at once, or with
/// the next control that is due.
void check_controller(const Measurement& figures, Checks& checks) {
  if (figures.from_device) return;
  // The controller stamps a sample when it reads it: later than others, when it had no processor.
  const double most_late = most_late_ms(figures);
  add_machine(checks, bounded(figures, "reading_spread_us", 1e3 * most_late),
              fmt::format("1 % of HIL_SENSOR was read {:.1f} ms later than the median one, and "
                          "{:g} ms is the most",
                          1e-3 * figures.reading_spread_us.value_or(0), most_late));
  if (figures.age_by_arrival.count == 0) return;
  const double control_hz = figures.rates.controls.nominal_hz;
  const double most_ms = most_late + (control_hz > 0 ? 1e3 / control_hz : 0);
  add_machine(checks, bounded(figures, "age_by_arrival_p99_us", 1e3 * most_ms),
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
      checks, bounded(figures, "port_gap_ms", kMostStallMs),
      fmt::format("no HIL_SENSOR came to the controller's port for {:.0f} ms, and {:.0f} ms "
                  "is the most",
                  *figures.port_gap_ms, kMostStallMs));
}

/// The conditions that the machine must meet in a run in real time, whoever the controller is.
Checks machine_checks(const Measurement& figures) {
  Checks checks;
  check_machine(figures, checks);
  check_controller(figures, checks);
  check_port(figures, checks);
  return checks;
}

/// Whether the limits on losses are missed by this stream.
bool loses_too_many(const RateFigures& rate, const Limits& limits) {
  if (rate.sent == 0) return false;
  const double delivered_pct =
      100.0 * static_cast<double>(rate.received) / static_cast<double>(rate.sent);
  return (limits.lost && rate.lost > *limits.lost) ||
         (limits.delivered_pct && delivered_pct < *limits.delivered_pct);
}

/// Losses that pauses of this machine explain: no more packets than were due in them. They may be
/// too few for the 99 % marks to show.
void check_pauses(const Measurement& figures, const Limits& limits, Checks& checks) {
  const double paused_ms = figures.paused_ms.value_or(0);
  if (paused_ms <= 0 || !figures.faults.empty()) return;  // a fault may hold packets up
  for (const Stream& stream : kStreams) {
    const RateFigures& rate = figures.rates.*stream.rate;
    const double due = std::ceil(1e-3 * paused_ms * rate.nominal_hz);
    if (!loses_too_many(rate, limits) || static_cast<double>(rate.lost) > due) continue;
    add_machine(checks, bounded(figures, "paused_ms", 0),
                fmt::format("{} of {} {} were lost, and as many were due while packets stood "
                            "still for {:.0f} ms between two programs",
                            rate.lost, rate.sent, stream.name, paused_ms));
    return;
  }
}

/// ArduPilot takes samples as fast as they come, and counts an External AHRS as ill when none has
/// come for 40 ms.
void check_ahrs(const Measurement& figures, Checks& checks) {
  constexpr double kMostGap_ms = 40;
  constexpr double kMostDropped_pct = 1;
  const AhrsFigures& line = *figures.firmware->ahrs;
  const auto all = static_cast<double>(line.sent + line.dropped);
  if (all == 0) {  // or its figures are lost
    checks.push_back(missed(validity("packets on the sensors' line", "none", "some"),
                            "the sensors' line carried no packet"));
    return;
  }
  const double dropped_pct = 100.0 * static_cast<double>(line.dropped) / all;
  check_pace(figures, checks);
  add_machine(checks,
              {.what = "longest gap on the sensors' line",
               .unit = "ms",
               .digits = 1,
               .value = line.longest_gap_ms,
               .bound = kMostGap_ms},
              fmt::format("nothing left on the sensors' line for {:.0f} ms, and {:.0f} ms is the "
                          "most",
                          line.longest_gap_ms, kMostGap_ms));
  add_machine(checks,
              {.what = "packets dropped on the sensors' line",
               .unit = "%",
               .digits = 2,
               .value = dropped_pct,
               .bound = kMostDropped_pct},
              fmt::format("{} of {:.0f} packets of the sensors' line were dropped, and {:g} % is "
                          "the most",
                          line.dropped, all, kMostDropped_pct));
}

/// The vehicle stayed on the ground for no reason that the flight shows: its autopilot disarms it
/// after a time, or somebody did. After an incident or a fault it has failed.
void check_arming(const Measurement& figures, Checks& checks) {
  if (!figures.firmware || !figures.firmware->disarmed_on_ground) return;
  const bool is_recorded = figures.truth_samples > 0 && !figures.record_hole;
  if (!figures.incidents.empty() || !figures.faults.empty() || !is_recorded) return;
  checks.push_back(missed(validity("the vehicle armed until it takes off", "disarmed", "armed"),
                          figures.flight_failure.value_or("") +
                              "; it stands upright and unhurt, no fault has struck, and hils does "
                              "not arm it again: the flight has no verdict"));
}

/// Whether the figures mean anything.
Checks validity_checks(const Measurement& figures, const Limits& limits) {
  Checks checks;
  if (!figures.virtual_clock && figures.streamed) {
    checks = machine_checks(figures);
    check_pauses(figures, limits, checks);
  }
  if (figures.firmware && figures.firmware->ahrs) check_ahrs(figures, checks);
  check_arming(figures, checks);
  if (!figures.stages.empty() && figures.truth_samples == 0) {
    checks.push_back(missed(validity("record of the true flight", "none", "there"),
                            "there is no record of the true flight"));
  } else if (figures.record_hole) {
    checks.push_back(missed(validity("record of the true flight", *figures.record_hole, "there"),
                            "the record of the true flight is not whole: " + *figures.record_hole));
  }
  if (figures.firmware) return checks;  // its own end of the stream keeps no ledger
  for (const Stream& stream : kStreams) {
    check_account(stream.name, figures.rates.*stream.rate, checks);
  }
  for (const PathAccount& path : figures.paths) {
    add_judged(checks,
               validity(fmt::format("account of {}, hop by hop", path.message),
                        path.closes() ? "closes" : "open", "closes"),
               path.closes(),
               fmt::format("the account of {} does not close: {}", path.message, path.open));
  }
  return checks;
}

void check_rate(const Stream& stream, const Measurement& figures, const Limits& limits,
                Checks& checks) {
  const auto& [key, name, member, _] = stream;
  const RateFigures& rate = figures.rates.*member;
  if (rate.sent == 0) {
    checks.push_back(
        missed({.what = fmt::format("{} sent", name), .found = "none", .wanted = "some"},
               fmt::format("no {} was sent", name)));
    return;
  }
  if (limits.lost) {
    add_bounded(checks,
                bounded(figures, fmt::format("{}_lost", key), static_cast<double>(*limits.lost)),
                fmt::format("{} of {} {} were lost; the limit is {}", rate.lost, rate.sent, name,
                            *limits.lost));
  }
  if (limits.delivered_pct) {
    LimitCheck check =
        bounded(figures, fmt::format("{}_delivered_pct", key), *limits.delivered_pct);
    const std::string sentence = fmt::format("{:.3f} % of {} arrived; the limit is {:g} %",
                                             *check.value, name, *limits.delivered_pct);
    add_bounded(checks, std::move(check), sentence);
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

/// Adds the check with its value, or with what was found instead.
void add_figure(Checks& checks, LimitCheck check, std::optional<double> value,
                const std::string& absent) {
  const std::string unit = check.unit.empty() ? "" : " " + check.unit;
  const std::string found = value ? fmt::format("{:.{}f}{}", *value, check.digits, unit) : absent;
  const std::string sentence =
      fmt::format("{}: {}; the limit is {:g}{}", check.what, found, *check.bound, unit);
  check.value = value;
  if (!value) check.found = absent;
  add_bounded(checks, std::move(check), sentence);
}

void add_unjudged(Checks& checks, LimitCheck check, const std::string& found) {
  check.found = found;
  check.judged = false;
  checks.push_back(std::move(check));
}

void check_responses(const std::vector<StepResponse>& responses,
                     const std::map<std::string, FigureLimits>& limits, Checks& checks) {
  for (const auto& [name, bounds] : limits) {
    const auto flown = std::ranges::find(responses, name, &StepResponse::name);
    const bool is_flown = flown != responses.end();
    add_judged(checks,
               {.what = fmt::format("step '{}'", name),
                .found = is_flown ? "flown" : "not flown",
                .wanted = "flown"},
               is_flown, fmt::format("step '{}' was not flown", name));
    for (const Figure<StepResponse>& row : response_table()) {
      const auto bound = bounds.find(row.key);
      if (bound == bounds.end()) continue;
      LimitCheck figure = bounded(row, fmt::format(" of step '{}'", name), bound->second);
      if (is_flown) {
        add_figure(checks, std::move(figure), row.get(*flown), "never");
      } else {
        add_unjudged(checks, std::move(figure), "not flown");
      }
    }
  }
}

/// Holds figures to their limits.
/// @param reached  whether the flight came to its measured step; else bounds on the motion there
///                 are not judged
void check_figures(const Measurement& figures, const FigureLimits& limits, bool reached,
                   Checks& checks) {
  for (const Figure<Measurement>& row : figure_table()) {
    const auto bound = limits.find(row.key);
    if (bound == limits.end()) continue;
    LimitCheck check = bounded(row, "", bound->second);
    if (row.key.starts_with("rms_")) check.about = LimitCheck::About::kRms;
    check_bound(std::move(check), row.get(figures),
                reached || row.part != Figure<Measurement>::Part::kMotion, checks);
  }
}

void check_flown(const Measurement& figures, Checks& checks) {
  LimitCheck check{.what = "flight",
                   .found = figures.flight_failure ? "not completed" : "completed",
                   .wanted = "completed"};
  if (figures.flight_failure && figures.under_way) {
    check.time_s = base::to_seconds(figures.under_way->end);
  } else if (!figures.stages.empty()) {
    check.time_s = base::to_seconds(figures.stages.back().end);
  }
  add_judged(checks, std::move(check), !figures.flight_failure,
             "the flight was not completed: " + figures.flight_failure.value_or(""));
}

/// Adds the incidents in the order of time, then the kinds that did not happen.
void check_incidents(const std::vector<Incident>& incidents, const Limits& limits, Checks& checks) {
  const auto wanted = [&limits](IncidentKind kind) {
    return limits.allow.contains(kind) ? "allowed" : "none";
  };
  const auto what = [](IncidentKind kind) { return fmt::format("incident: {}", to_string(kind)); };
  for (const Incident& incident : incidents) {
    add_judged(checks,
               {.what = what(incident.kind),
                .found = fmt::format("at {:.2f} s", incident.time_s),
                .wanted = wanted(incident.kind),
                .time_s = incident.time_s},
               limits.allow.contains(incident.kind), "the vehicle " + incident.what);
  }
  for (const IncidentKind kind : kIncidentKinds) {
    if (std::ranges::find(incidents, kind, &Incident::kind) != incidents.end()) continue;
    checks.push_back({.what = what(kind), .found = "none", .wanted = wanted(kind)});
  }
}

/// Checks of stock firmware: its messages, its fence, and whether it flew what it says.
void check_firmware(const Measurement& figures, const Limits& limits, Checks& checks) {
  const FirmwareRecord& firmware = *figures.firmware;
  for (const auto& [name, least_hz] : limits.rates_hz) {
    LimitCheck check{.what = "rate of " + name,
                     .unit = "Hz",
                     .digits = 1,
                     .sense = Sense::kAtLeast,
                     .bound = least_hz};
    std::optional<double> rate;
    if (!firmware.rates_hz.empty()) rate = 0;
    if (const auto own = firmware.rates_hz.find(name); own != firmware.rates_hz.end()) {
      rate = own->second;
    }
    check_bound(std::move(check), rate, figures.over_hold, checks);
  }
  if (figures.fence && firmware.fence) {
    std::vector<Stage> flown = figures.stages;
    if (figures.under_way) flown.push_back(*figures.under_way);
    std::ranges::move(fence_checks(*figures.fence, *firmware.fence, flown),
                      std::back_inserter(checks));
  }
  const bool is_flown = figures.not_flown.empty();
  add_judged(checks,
             {.what = "steps by the true flight",
              .found = is_flown ? "flown" : "not flown",
              .wanted = "flown"},
             is_flown, fmt::format("{}", fmt::join(figures.not_flown, "; ")));
}

Checks flight_checks(const Measurement& figures, const Limits& limits) {
  Checks checks;
  check_incidents(figures.incidents, limits, checks);  // first: a crash is why it was not flown
  check_flown(figures, checks);
  const bool is_limited = limits.lost || limits.delivered_pct || limits.rate_error_pct;
  if (!figures.firmware || (figures.port_gap_ms && is_limited)) {
    for (const Stream& stream : kStreams) check_rate(stream, figures, limits, checks);
  }
  check_responses(figures.responses, limits.responses, checks);
  check_figures(figures, limits.figures, figures.over_hold, checks);
  if (figures.firmware) check_firmware(figures, limits, checks);
  return checks;
}

Checks fault_checks(const std::vector<FaultThatNeverBegan>& faults) {
  Checks checks;
  for (const FaultThatNeverBegan& fault : faults) {
    checks.push_back(
        missed(validity(fmt::format("fault '{}'", fault.name), "never began", "begins"),
               fmt::format("fault '{}' never began: {}", fault.name,
                           fault.by_time ? "the flight ended before its time"
                                         : "its condition never came true")));
  }
  return checks;
}

/// The remedy for a busy machine follows the last sentence that says so.
std::vector<std::string> sentences_of(const Checks& checks) {
  std::vector<std::string> sentences;
  std::size_t busy = 0;  // behind the last one
  for (const LimitCheck& check : checks) {
    if (check.kept) continue;
    sentences.push_back(check.sentence);
    if (check.about == LimitCheck::About::kMachine) busy = sentences.size();
  }
  if (busy > 0) sentences[busy - 1] += kRemedy;
  return sentences;
}

/// A remark on a verdict whose limits leave a swing in the measured step unjudged; nullopt: they
/// do not.
std::optional<std::string> unlimited_motion(const Limits& limits) {
  const auto is_of_truth = [](const auto& limit) {
    const std::string& key = limit.first;
    return key == "peak_error_m" || (key.starts_with("rms_") && !key.starts_with("rms_estimate_"));
  };
  if (!limits.responses.empty() || std::ranges::any_of(limits.figures, is_of_truth)) {
    return std::nullopt;
  }
  return "the scenario limits neither rms nor peak_error_m: how well the measured step was flown "
         "is not judged";
}

/// A remark on the bounds of machine_checks() that do not judge a board; nullopt: all do.
std::optional<std::string> unjudged_with_board(const Measurement& figures) {
  if (!figures.from_device || !figures.streamed) return std::nullopt;
  std::vector<std::string> bounds;
  const auto add = [&](bool is_measured, std::string_view key) {
    bounds.push_back(figure_row(key).title + (is_measured ? " (measured)" : " (not measured)"));
  };
  if (!figures.handover_p99_us) add(false, "handover_p99_us");
  add(figures.reading_spread_us.has_value(), "reading_spread_us");
  add(figures.age_by_arrival.count > 0, "age_by_arrival_p99_us");
  return fmt::format("not judged with a board: {}", fmt::join(bounds, "; "));
}

/// The verdict on a run. A flight that would have passed has none when a fault never began; one
/// that failed may have ended before its faults, so those are remarks.
/// @param validity  whether the run counts; the flight of one that does not is not judged
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

/// Adds the sentences that are not there yet.
void add_new(const std::vector<std::string>& sentences, std::vector<std::string>& all) {
  for (const std::string& sentence : sentences) {
    if (std::ranges::find(all, sentence) == all.end()) all.push_back(sentence);
  }
}

}  // namespace

void check_bound(LimitCheck bounded, std::optional<double> value, bool reached,
                 std::vector<LimitCheck>& checks) {
  if (value || reached) return add_figure(checks, std::move(bounded), value, "not measured");
  add_unjudged(checks, std::move(bounded), "not reached");
}

double most_late_ms(const Measurement& figures) {
  constexpr double kSlowest_hz = 200;  // a stream that has no rate of its own
  const double hz = figures.rates.sensor.nominal_hz;
  return 1e3 / (hz > 0 ? hz : kSlowest_hz);
}

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
  Verdict verdict = verdict_on(validity_checks(figures, limits), flight_checks(figures, limits),
                               figures.never_began);
  if (figures.firmware) verdict.remarks = figures.firmware->remarks;
  if (auto remark = unlimited_motion(limits)) verdict.remarks.push_back(std::move(*remark));
  if (auto remark = unjudged_with_board(figures)) verdict.remarks.push_back(std::move(*remark));
  verdict.warnings = figures.warnings;
  return verdict;
}

}  // namespace cas::hils
