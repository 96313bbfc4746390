// SPDX-License-Identifier: BSD-3-Clause
#include "hils/compare/comparison_table.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <map>
#include <string_view>

#include "hils/report/experiment.hpp"
#include "hils/report/number_text.hpp"
#include "hils/report/paper_figures.hpp"

namespace cas::hils {

namespace {

Figure number(double (*get)(const Measurement&)) {
  return [get](const Measurement& figures) -> std::optional<double> { return get(figures); };
}

Figure rms(double RmsFigures::*member) {
  return [member](const Measurement& figures) -> std::optional<double> {
    if (!figures.rms) return std::nullopt;
    return *figures.rms.*member;
  };
}

Figure delay(DelayFigures Measurement::*which, double DelayFigures::*member) {
  return [which, member](const Measurement& figures) -> std::optional<double> {
    if ((figures.*which).count == 0) return std::nullopt;
    return figures.*which.*member;
  };
}

double delivered_pct(const RateFigures& rate) {
  return rate.sent == 0
             ? 0
             : 100.0 * static_cast<double>(rate.received) / static_cast<double>(rate.sent);
}

/// Percentiles of one delay: p50, p90, p99, longest.
void add_delay(ColumnGroup& group, const std::string& key, const std::string& title,
               DelayFigures Measurement::*which) {
  group.columns.push_back({key + "_p50_us", title + " p50", 0, delay(which, &DelayFigures::p50)});
  group.columns.push_back({key + "_p90_us", "p90", 0, delay(which, &DelayFigures::p90)});
  group.columns.push_back({key + "_p99_us", "p99", 0, delay(which, &DelayFigures::p99)});
  group.columns.push_back({key + "_max_us", "max", 0, delay(which, &DelayFigures::max)});
}

ColumnGroup rates() {
  using M = const Measurement&;
  return {
      "rates",
      "Table 4. Rates at the receiver: mean and 95 % interval over the seeds; error: how far they "
      "fall "
      "short of the nominal rate, negative above it",
      {{"sensor_hz", "IMU Hz", 4, number([](M m) { return m.rates.sensor.received_hz; })},
       {"sensor_error_pct", "error %", 4, number([](M m) { return m.rates.sensor.error_pct; })},
       {"gps_hz", "GPS Hz", 4, number([](M m) { return m.rates.gps.received_hz; })},
       {"gps_error_pct", "error %", 4, number([](M m) { return m.rates.gps.error_pct; })},
       {"controls_hz", "control Hz", 4, number([](M m) { return m.rates.controls.received_hz; })},
       {"controls_error_pct", "error %", 4,
        number([](M m) { return m.rates.controls.error_pct; })}}};
}

ColumnGroup rms_errors() {
  ColumnGroup group{
      "rms", "Table 5. RMS error while measured, true position against the reference", {}};
  for (const RmsAxis& axis : kRmsAxes) {
    group.columns.push_back(
        {std::string(axis.key), fmt::format("{} {}", axis.name, axis.unit), 4, rms(axis.member)});
  }
  return group;
}

ColumnGroup delivery() {
  using M = const Measurement&;
  return {
      "delivered",
      "Delivered packets, and the rate as QGroundControl's averaging meter would have shown it",
      {{"sensor_pct", "IMU %", 4, number([](M m) { return delivered_pct(m.rates.sensor); })},
       {"gps_pct", "GPS %", 4, number([](M m) { return delivered_pct(m.rates.gps); })},
       {"controls_pct", "control %", 4,
        number([](M m) { return delivered_pct(m.rates.controls); })},
       {"meter_sensor_hz", "IMU meter Hz", 2, number([](M m) { return m.meter.sensor_hz; })},
       {"meter_gps_hz", "GPS meter", 3, number([](M m) { return m.meter.gps_hz; })},
       {"meter_controls_hz", "control meter", 2, number([](M m) { return m.meter.controls_hz; })}}};
}

ColumnGroup delays(const std::string& key, const std::string& title,
                   DelayFigures Measurement::*which) {
  ColumnGroup group{key, title, {}};
  add_delay(group, key, "us:", which);
  return group;
}

ColumnGroup ages() {
  ColumnGroup group{"age",
                    "Age of the sample when the controller used it, us: since the simulator made "
                    "it, and since it came to the controller",
                    {}};
  group.columns = {
      {"by_stamp_p50_us", "made p50", 0, delay(&Measurement::age_by_stamp, &DelayFigures::p50)},
      {"by_stamp_p99_us", "p99", 0, delay(&Measurement::age_by_stamp, &DelayFigures::p99)},
      {"by_arrival_p50_us", "arrived p50", 0,
       delay(&Measurement::age_by_arrival, &DelayFigures::p50)},
      {"by_arrival_p99_us", "p99", 0, delay(&Measurement::age_by_arrival, &DelayFigures::p99)}};
  return group;
}

/// Real time only: a virtual clock knows neither.
ColumnGroup machine() {
  const auto cpu = [](const Measurement& figures) -> std::optional<double> {
    if (figures.virtual_clock) return std::nullopt;
    double sum = 0;
    for (const auto& [program, seconds] : figures.cpu_s) {
      if (program == "casd") sum += seconds;
    }
    return figures.wall_s > 0 ? 100 * sum / figures.wall_s : 0;
  };
  const auto pace = [](const Measurement& figures) -> std::optional<double> {
    if (figures.virtual_clock) return std::nullopt;
    return figures.pace.real_time_factor;
  };
  const auto stall = [](const Measurement& figures) -> std::optional<double> {
    if (figures.virtual_clock) return std::nullopt;
    return figures.pace.worst_stall_ms;
  };
  return {"machine",
          "The machine (real time only)",
          {{"casd_cpu_pct", "casd, % of a processor", 2, cpu},
           {"real_time_factor", "real-time factor", 4, pace},
           {"worst_stall_ms", "longest stall ms", 1, stall}}};
}

const VariantResult* find(const std::vector<VariantResult>& results, Architecture architecture,
                          unsigned baud, std::size_t& index) {
  for (index = 0; index < results.size(); ++index) {
    const Variant& variant = results[index].variant;
    if (variant.architecture == architecture && variant.baud == baud) return &results[index];
  }
  return nullptr;
}

constexpr std::array<std::string_view, 11> kCompared{
    "sensor_hz", "gps_hz",        "controls_hz",     "x_m",        "y_m", "z_m", "yaw_rad",
    "gps_pct",   "uplink_p50_us", "downlink_p50_us", "loop_p99_us"};

void add_paper_rows(const ColumnGroup& group, Rows& rows) {
  if (group.key == "rates") {
    for (const PaperRates& row : kPaperTable4) {
      rows.push_back({fmt::format("[HILS] {}", row.name)});
      for (const double value : {row.sensor_hz, row.sensor_error_pct, row.gps_hz, row.gps_error_pct,
                                 row.controls_hz, row.controls_error_pct}) {
        rows.back().push_back(fmt::format("{:.4f}", value));
      }
    }
  }
  if (group.key == "rms") {
    for (const PaperRms& row : kPaperTable5) {
      rows.push_back({fmt::format("[HILS] {}", row.name)});
      for (const double value : {row.x_m, row.y_m, row.z_m, row.yaw_rad}) {
        rows.back().push_back(fmt::format("{:.4f}", value));
      }
    }
  }
}

}  // namespace

const std::vector<ColumnGroup>& comparison_groups() {
  static const std::vector<ColumnGroup> kGroups{
      rates(),
      rms_errors(),
      delivery(),
      delays("uplink", "HIL_SENSOR from the simulator to the controller",
             &Measurement::sensor_uplink),
      delays("downlink", "Controls from the controller to the simulator",
             &Measurement::controls_downlink),
      delays("loop", "HIL_SENSOR out to the control made from it back",
             &Measurement::sensor_to_control),
      ages(),
      machine()};
  return kGroups;
}

std::optional<Mean> mean_of_valid(const VariantResult& result, const Column& column) {
  std::vector<double> values;
  for (std::size_t i = 0; i < result.runs.size(); ++i) {
    if (!result.verdicts[i].valid) continue;
    if (const auto value = column.figure(result.runs[i])) values.push_back(*value);
  }
  if (values.empty()) return std::nullopt;
  return mean_of(values);
}

std::optional<Mean> difference_of(const VariantResult& a, const VariantResult& b,
                                  const Column& column) {
  std::vector<double> of_a;
  std::vector<double> of_b;
  for (std::size_t i = 0; i < std::min(a.runs.size(), b.runs.size()); ++i) {
    if (!a.verdicts[i].valid || !b.verdicts[i].valid) continue;
    const auto value_a = column.figure(a.runs[i]);
    const auto value_b = column.figure(b.runs[i]);
    if (!value_a || !value_b) continue;
    of_a.push_back(*value_a);
    of_b.push_back(*value_b);
  }
  if (of_a.empty()) return std::nullopt;
  return mean_difference(of_a, of_b);
}

std::vector<std::pair<std::size_t, std::size_t>> comparison_pairs(
    const std::vector<VariantResult>& results) {
  std::vector<std::pair<std::size_t, std::size_t>> pairs;
  for (std::size_t i = 0; i < results.size(); ++i) {
    if (results[i].variant.architecture != Architecture::kTcas) continue;
    for (const Architecture other : {Architecture::kTs, Architecture::kLoop, Architecture::kSitl}) {
      const unsigned baud = other == Architecture::kSitl ? 0 : results[i].variant.baud;
      std::size_t j = 0;
      if (find(results, other, baud, j) != nullptr) pairs.emplace_back(i, j);
    }
  }
  return pairs;
}

std::string to_text(const std::optional<Mean>& mean, int digits) {
  if (!mean) return "-";
  if (mean->count < 2) return fixed(mean->mean, digits);
  return fmt::format("{} ± {}", fixed(mean->mean, digits), fixed(mean->half_width, digits));
}

std::map<std::string, std::uint64_t> losses_of(const VariantResult& result) {
  std::map<std::string, std::uint64_t> losses;
  for (std::size_t i = 0; i < result.runs.size(); ++i) {
    if (!result.verdicts[i].valid) continue;
    for (const PathAccount& path : result.runs[i].paths) {
      for (const auto& [cause, count] : path.losses) losses[path.message + ": " + cause] += count;
    }
  }
  return losses;
}

std::uint64_t sent_of(const VariantResult& result) {
  std::uint64_t sent = 0;
  for (std::size_t i = 0; i < result.runs.size(); ++i) {
    if (!result.verdicts[i].valid) continue;
    for (const PathAccount& path : result.runs[i].paths) sent += path.sent;
  }
  return sent;
}

bool has_figures(const ColumnGroup& group, const std::vector<VariantResult>& results) {
  return std::ranges::any_of(results, [&](const VariantResult& result) {
    return std::ranges::any_of(group.columns, [&](const Column& column) {
      return mean_of_valid(result, column).has_value();
    });
  });
}

Rows group_rows(const ColumnGroup& group, const std::vector<VariantResult>& results) {
  Rows rows{{""}};
  for (const Column& column : group.columns) rows.front().push_back(column.title);
  for (const VariantResult& result : results) {
    rows.push_back({result.variant.name()});
    for (const Column& column : group.columns) {
      rows.back().push_back(to_text(mean_of_valid(result, column), column.digits));
    }
  }
  const bool is_comparable = std::ranges::all_of(results, [](const VariantResult& result) {
    return std::ranges::all_of(result.runs, measures_station_keeping);
  });
  if (group.key != "rms" || is_comparable) add_paper_rows(group, rows);
  return rows;
}

Rows loss_rows(const std::vector<VariantResult>& results) {
  Rows rows{{"", "packets lost", "of", "what and where"}};
  for (const VariantResult& result : results) {
    const std::uint64_t sent = sent_of(result);
    const auto losses = losses_of(result);
    if (losses.empty()) {
      rows.push_back({result.variant.name(), "0", fmt::format("{}", sent), ""});
    }
    for (const auto& [cause, count] : losses) {
      rows.push_back(
          {result.variant.name(), fmt::format("{}", count), fmt::format("{}", sent), cause});
    }
  }
  return rows;
}

Rows difference_rows(const std::vector<VariantResult>& results) {
  Rows rows{{""}};
  std::vector<Column> columns;
  for (const ColumnGroup& group : comparison_groups()) {
    for (const Column& column : group.columns) {
      if (std::ranges::count(kCompared, column.key) == 0) continue;
      columns.push_back(column);
      rows.front().push_back(column.key);
    }
  }
  for (const auto& [a, b] : comparison_pairs(results)) {
    rows.push_back({results[a].variant.name() + " less " + results[b].variant.name()});
    for (const Column& column : columns) {
      rows.back().push_back(to_text(difference_of(results[a], results[b], column), column.digits));
    }
  }
  return rows;
}

}  // namespace cas::hils
