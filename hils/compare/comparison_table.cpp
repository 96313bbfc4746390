// SPDX-License-Identifier: BSD-3-Clause
#include "hils/compare/comparison_table.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <initializer_list>
#include <iterator>
#include <map>
#include <string_view>

#include "hils/measure/figure_table.hpp"
#include "hils/report/experiment.hpp"
#include "hils/report/figure_rows.hpp"
#include "hils/report/number_text.hpp"

namespace cas::hils {

namespace {

std::vector<FigureColumn> columns(std::initializer_list<std::string_view> keys) {
  std::vector<FigureColumn> rows;
  for (const std::string_view key : keys) rows.push_back(&figure_row(key));
  return rows;
}

/// @param delay  of kDelays
ColumnGroup delays(const std::string& title, const std::string& delay) {
  return {title,
          columns({delay + "_p50_us", delay + "_p90_us", delay + "_p99_us", delay + "_max_us"})};
}

/// The virtual clock knows no figure of the machine.
std::optional<double> value_of(FigureColumn column, const Measurement& figures) {
  const bool of_machine = column->part == Figure<Measurement>::Part::kRun;
  return of_machine && figures.virtual_clock ? std::nullopt : column->get(figures);
}

const VariantResult* find(const std::vector<VariantResult>& results, Architecture architecture,
                          unsigned baud, std::size_t& index) {
  for (index = 0; index < results.size(); ++index) {
    const Variant& variant = results[index].variant;
    if (variant.architecture == architecture && variant.baud == baud) return &results[index];
  }
  return nullptr;
}

}  // namespace

const std::vector<ColumnGroup>& comparison_groups() {
  static const std::vector<ColumnGroup> kGroups{
      {"Table 4. Rates at the receiver: mean and 95 % interval over the seeds; error: how far they "
       "fall short of the nominal rate, negative above it",
       columns({"sensor_hz", "sensor_rate_error_pct", "gps_hz", "gps_rate_error_pct", "controls_hz",
                "controls_rate_error_pct"}),
       PaperTable::kRates},
      {"Table 5. RMS error while measured, true position against the reference",
       columns({"rms_x_m", "rms_y_m", "rms_z_m", "rms_yaw_rad"}), PaperTable::kRms},
      {"Motion in the measured step; of stock firmware a hold about its mean",
       columns({"peak_error_m", "height_error_m", "drift_m", "rotor_activity_rad_s2",
                "rms_estimate_x_m", "rms_estimate_y_m", "rms_estimate_z_m",
                "rms_estimate_yaw_rad"})},
      {"Delivered packets, and the rate as QGroundControl's averaging meter would have shown it",
       columns({"sensor_delivered_pct", "gps_delivered_pct", "controls_delivered_pct",
                "sensor_meter_hz", "gps_meter_hz", "controls_meter_hz"})},
      delays("HIL_SENSOR from the simulator to the controller", "sensor_uplink"),
      delays("Controls from the controller to the simulator", "controls_downlink"),
      delays("HIL_SENSOR out to the control made from it back", "sensor_to_control"),
      {"Age of the sample when the controller used it, us: since the simulator made it, and since "
       "it came to the controller",
       columns({"age_by_stamp_p50_us", "age_by_stamp_p99_us", "age_by_arrival_p50_us",
                "age_by_arrival_p99_us"})},
      {"The machine (real time only)",
       columns({"casd_cpu_pct", "real_time_factor", "worst_stall_ms"})}};
  return kGroups;
}

std::optional<Mean> mean_of_valid(const VariantResult& result, FigureColumn column) {
  std::vector<double> values;
  for (std::size_t i = 0; i < result.runs.size(); ++i) {
    if (!result.verdicts[i].valid) continue;
    if (const auto value = value_of(column, result.runs[i])) values.push_back(*value);
  }
  if (values.empty()) return std::nullopt;
  return mean_of(values);
}

std::optional<Mean> difference_of(const VariantResult& a, const VariantResult& b,
                                  FigureColumn column) {
  std::vector<double> of_a;
  std::vector<double> of_b;
  for (std::size_t i = 0; i < std::min(a.runs.size(), b.runs.size()); ++i) {
    if (!a.verdicts[i].valid || !b.verdicts[i].valid) continue;
    const auto value_a = value_of(column, a.runs[i]);
    const auto value_b = value_of(column, b.runs[i]);
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
    const Variant& variant = results[i].variant;
    if (variant.architecture != Architecture::kTcas || !variant.scenario_name.empty()) continue;
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
    return std::ranges::any_of(group.columns, [&](FigureColumn column) {
      return mean_of_valid(result, column).has_value();
    });
  });
}

Rows group_rows(const ColumnGroup& group, const std::vector<VariantResult>& results) {
  Rows rows{{""}};
  for (const FigureColumn column : group.columns) rows.front().push_back(column->key);
  for (const VariantResult& result : results) {
    rows.push_back({result.variant.name()});
    for (const FigureColumn column : group.columns) {
      rows.back().push_back(to_text(mean_of_valid(result, column), column->digits));
    }
  }
  const bool is_of_one_scenario = results.empty() || results[0].variant.scenario_name.empty();
  const bool is_comparable =
      is_of_one_scenario && std::ranges::all_of(results, [](const VariantResult& result) {
        return std::ranges::all_of(result.runs, measures_station_keeping);
      });
  const bool has_rates = group.paper == PaperTable::kRates;
  const bool has_rms = group.paper == PaperTable::kRms && is_comparable;
  if (has_rates && is_of_one_scenario)
    std::ranges::move(paper_rate_rows(), std::back_inserter(rows));
  if (has_rms) std::ranges::move(paper_rms_rows(), std::back_inserter(rows));
  return rows;
}

Rows loss_rows(const std::vector<VariantResult>& results) {
  Rows rows{{"", "packets lost", "of", "what and where"}};
  for (const VariantResult& result : results) {
    const std::uint64_t sent = sent_of(result);
    const auto losses = losses_of(result);
    if (sent == 0) {  // firmware in software, or no valid run
      rows.push_back({result.variant.name(), "-", "-", "not counted"});
    } else if (losses.empty()) {
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
  static const std::vector<FigureColumn> kCompared =
      columns({"sensor_hz", "gps_hz", "controls_hz", "rms_x_m", "rms_y_m", "rms_z_m", "rms_yaw_rad",
               "gps_delivered_pct", "sensor_uplink_p50_us", "controls_downlink_p50_us",
               "sensor_to_control_p99_us"});
  for (const FigureColumn column : kCompared) rows.front().push_back(column->key);
  for (const auto& [a, b] : comparison_pairs(results)) {
    rows.push_back({results[a].variant.name() + " less " + results[b].variant.name()});
    for (const FigureColumn column : kCompared) {
      rows.back().push_back(to_text(difference_of(results[a], results[b], column), column->digits));
    }
  }
  return rows;
}

}  // namespace cas::hils
