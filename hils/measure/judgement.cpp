// SPDX-License-Identifier: BSD-3-Clause
#include "hils/measure/judgement.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>
#include <utility>

namespace cas::hils {

namespace {

using Sentences = std::vector<std::string>;
using NamedRate = std::pair<std::string_view, const RateFigures*>;

std::array<NamedRate, 3> named_rates(const StreamFigures& rates) {
  return {NamedRate{"HIL_SENSOR", &rates.sensor}, NamedRate{"HIL_GPS", &rates.gps},
          NamedRate{"HIL_CONTROLS", &rates.controls}};
}

void check_account(std::string_view name, const RateFigures& rate, Sentences& reasons) {
  if (rate.duplicated > 0) {
    reasons.push_back(fmt::format("the account of {} does not close: {} packets arrived twice",
                                  name, rate.duplicated));
  }
  if (rate.unexplained > 0) {
    reasons.push_back(
        fmt::format("the account of {} does not close: {} packets arrived that were never sent",
                    name, rate.unexplained));
  }
  if (!rate.drained) {
    reasons.push_back(fmt::format(
        "the account of {} does not close: the stream ended before its packets could arrive",
        name));
  }
}

constexpr const char* kRemedy =
    "; end other programs, or give these real-time rights (docs/operations.md), or use --virtual";

/// Whether simulator and programs kept up with real time, before any limit is looked at: a delay of
/// theirs is none of the vehicle's.
void check_machine(const Measurement& figures, Sentences& reasons) {
  const PaceFigures& pace = figures.pace;
  const auto busy = [&reasons](const std::string& what) {
    reasons.push_back("the machine was too busy: " + what + kRemedy);
  };
  if (!(pace.real_time_factor >= kLeastRealTimeFactor)) {
    busy(fmt::format("the simulation ran at {:.3f} of real time, and {:.2f} is needed",
                     pace.real_time_factor, kLeastRealTimeFactor));
  }
  if (pace.worst_stall_ms > kMostStallMs) {
    busy(fmt::format("the simulation stood still for {:.0f} ms, and {:.0f} ms is the most",
                     pace.worst_stall_ms, kMostStallMs));
  }
  const double most_ms = most_late_ms(figures);
  if (pace.late_p99_ms > most_ms) {
    busy(fmt::format("1 % of HIL_SENSOR left {:.1f} ms late or later, and {:g} ms is the most",
                     pace.late_p99_ms, most_ms));
  }
  if (figures.handover_p99_us > 1e3 * most_ms) {
    busy(
        fmt::format("simulator and casd took {:.1f} ms to hand a packet over in 1 % of the cases, "
                    "and {:g} ms is the most",
                    1e-3 * figures.handover_p99_us, most_ms));
  }
}

/// What is late in the emulated controller is the machine's, too: it answers a sample at once, or
/// with the next control that is due.
void check_controller(const Measurement& figures, Sentences& reasons) {
  if (figures.from_device) return;
  // It stamps a sample when it reads it: later than others, when it had no processor.
  const double most_late = most_late_ms(figures);
  const double spread_ms = 1e-3 * figures.reading_spread_us;
  if (spread_ms > most_late) {
    reasons.push_back(
        fmt::format("the machine was too busy: 1 % of HIL_SENSOR was read {:.1f} ms later than "
                    "the median one, and {:g} ms is the most{}",
                    spread_ms, most_late, kRemedy));
  }
  if (figures.age_by_arrival.count == 0) return;
  const double control_hz = figures.rates.controls.nominal_hz;
  const double most_ms = most_late + (control_hz > 0 ? 1e3 / control_hz : 0);
  if (figures.age_by_arrival.p99 <= 1e3 * most_ms) return;
  reasons.push_back(
      fmt::format("the machine was too busy: the controller took {:.1f} ms from a sample to its "
                  "answer in 1 % of "
                  "the cases, and {:g} ms is the most{}",
                  1e-3 * figures.age_by_arrival.p99, most_ms, kRemedy));
}

/// Why the figures mean nothing; empty when they do.
Sentences reasons_against(const Measurement& figures) {
  Sentences reasons;
  if (!figures.virtual_clock) {
    check_machine(figures, reasons);
    check_controller(figures, reasons);
  }
  if (!figures.stages.empty() && figures.truth_samples == 0) {
    reasons.push_back("there is no record of the true flight");
  }
  for (const auto& [name, rate] : named_rates(figures.rates)) {
    check_account(name, *rate, reasons);
  }
  for (const PathAccount& path : figures.paths) {
    if (!path.closes()) {
      reasons.push_back(
          fmt::format("the account of {} does not close: {}", path.message, path.open));
    }
  }
  return reasons;
}

void check_rate(std::string_view name, const RateFigures& rate, const Limits& limits,
                Sentences& failures) {
  if (rate.sent == 0) {
    failures.push_back(fmt::format("no {} was sent", name));
    return;
  }
  if (limits.lost && rate.lost > *limits.lost) {
    failures.push_back(fmt::format("{} of {} {} were lost; the limit is {}", rate.lost, rate.sent,
                                   name, *limits.lost));
  }
  const double delivered =
      100.0 * static_cast<double>(rate.received) / static_cast<double>(rate.sent);
  if (limits.delivered_pct && !(delivered >= *limits.delivered_pct)) {
    failures.push_back(fmt::format("{:.3f} % of {} arrived; the limit is {:g} %", delivered, name,
                                   *limits.delivered_pct));
  }
  if (limits.rate_error_pct && std::abs(rate.error_pct) > *limits.rate_error_pct) {
    failures.push_back(
        fmt::format("{} arrived at {:.2f} Hz instead of {:g} Hz; the limit is {:g} %", name,
                    rate.received_hz, rate.nominal_hz, *limits.rate_error_pct));
  }
}

void check_rms(std::string_view what, const std::optional<RmsFigures>& rms,
               const std::map<std::string, double>& limits, Sentences& failures) {
  if (limits.empty()) return;
  if (!rms || rms->samples == 0) {
    failures.push_back(fmt::format("there is no {} to compare with the reference", what));
    return;
  }
  const std::map<std::string, double> values{
      {"x_m", rms->x_m}, {"y_m", rms->y_m}, {"z_m", rms->z_m}, {"yaw_rad", rms->yaw_rad}};
  for (const auto& [axis, limit] : limits) {
    const double value = values.at(axis);
    if (value <= limit) continue;  // not-a-number fails
    failures.push_back(fmt::format("RMS error of the {} in {} is {:.4f}; the limit is {:g}", what,
                                   axis, value, limit));
  }
}

void check_most(std::string_view what, const StepResponse& response, std::optional<double> value,
                std::optional<double> limit, Sentences& failures) {
  if (!limit || (value && *value <= *limit)) return;
  failures.push_back(value
                         ? fmt::format("{} of step '{}' is {:.3f}; the limit is {:g}", what,
                                       response.name, *value, *limit)
                         : fmt::format("step '{}' ends before there is a {}", response.name, what));
}

void check_responses(const std::vector<StepResponse>& responses,
                     const std::map<std::string, ResponseLimits>& limits, Sentences& failures) {
  for (const auto& [name, limit] : limits) {
    const auto found = std::ranges::find(responses, name, &StepResponse::name);
    if (found == responses.end()) {
      failures.push_back(fmt::format("step '{}' was not flown", name));
      continue;
    }
    check_most("rise time", *found, found->rise_s, limit.rise_s, failures);
    check_most("overshoot", *found, found->overshoot_pct, limit.overshoot_pct, failures);
    check_most("settling time", *found, found->settling_s, limit.settling_s, failures);
  }
}

Sentences missed_limits(const Measurement& figures, const Limits& limits) {
  Sentences failures;
  if (!figures.flight_failure.empty()) {
    failures.push_back("the flight was not completed: " + figures.flight_failure);
  }
  for (const Incident& incident : figures.incidents) {
    if (!limits.allow.contains(incident.kind)) failures.push_back("the vehicle " + incident.what);
  }
  for (const auto& [name, rate] : named_rates(figures.rates)) {
    check_rate(name, *rate, limits, failures);
  }
  if (limits.latency_p99_us && figures.sensor_to_control.count == 0) {
    failures.push_back("the loop's delay has a limit, but no packet to measure it by");
  } else if (limits.latency_p99_us && !(figures.sensor_to_control.p99 <= *limits.latency_p99_us)) {
    failures.push_back(
        fmt::format("the loop takes {:.0f} us in 99 % of the cases; the limit is "
                    "{:g} us",
                    figures.sensor_to_control.p99, *limits.latency_p99_us));
  }
  check_responses(figures.responses, limits.responses, failures);
  if (figures.over_hold) {
    check_rms("true position", figures.rms, limits.rms, failures);
    check_rms("estimate", figures.rms_estimate, limits.rms_estimate, failures);
  }
  return failures;
}

}  // namespace

double most_late_ms(const Measurement& figures) {
  constexpr double kSlowest_hz = 200;  // a stream that has no rate of its own
  const double hz = figures.rates.sensor.nominal_hz;
  return 1e3 / (hz > 0 ? hz : kSlowest_hz);
}

Verdict judge(const Measurement& figures, const Limits& limits) {
  Verdict verdict;
  verdict.failures = reasons_against(figures);
  if (!verdict.failures.empty()) return verdict;
  verdict.failures = missed_limits(figures, limits);
  verdict.passed = verdict.failures.empty();
  verdict.valid = true;
  return verdict;
}

}  // namespace cas::hils
