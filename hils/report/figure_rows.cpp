// SPDX-License-Identifier: BSD-3-Clause
#include "hils/report/figure_rows.hpp"

#include <fmt/format.h>

#include <initializer_list>

#include "base/time/clock.hpp"
#include "hils/measure/figure_table.hpp"
#include "hils/report/experiment.hpp"
#include "hils/report/number_text.hpp"
#include "hils/report/paper_figures.hpp"

namespace cas::hils {

namespace {

Row paper_row(std::string_view name, std::initializer_list<double> values) {
  Row row{fmt::format("[HILS] {}", name)};
  for (const double value : values) row.push_back(fixed(value, 4));
  return row;
}

}  // namespace

Row figure_cells(const Measurement& figures, const std::string& name,
                 const std::vector<std::string>& keys) {
  Row cells{name};
  for (const std::string& key : keys) {
    const Figure<Measurement>& row = figure_row(key);
    cells.push_back(fixed(row.get(figures), row.digits));
  }
  return cells;
}

Rows paper_rate_rows() {
  Rows rows;
  for (const PaperRates& paper : kPaperTable4) {
    rows.push_back(
        paper_row(paper.name, {paper.sensor_hz, paper.sensor_error_pct, paper.gps_hz,
                               paper.gps_error_pct, paper.controls_hz, paper.controls_error_pct}));
  }
  return rows;
}

Rows paper_rms_rows() {
  Rows rows;
  for (const PaperRms& paper : kPaperTable5) {
    rows.push_back(paper_row(paper.name, {paper.x_m, paper.y_m, paper.z_m, paper.yaw_rad}));
  }
  return rows;
}

Row rate_row(const Measurement& figures) {
  return figure_cells(figures, controller_name(figures),
                      {"sensor_hz", "sensor_rate_error_pct", "gps_hz", "gps_rate_error_pct",
                       "controls_hz", "controls_rate_error_pct"});
}

Rows delay_rows(const Measurement& figures) {
  Rows rows{{"Delay, us", "packets", "median", "99 %", "longest"}};
  for (const Delay& delay : kDelays) {
    const std::string key(delay.key);
    rows.push_back(
        figure_cells(figures, std::string(delay.title),
                     {key + "_count", key + "_p50_us", key + "_p99_us", key + "_max_us"}));
  }
  return rows;
}

std::vector<std::string> rms_keys(std::string_view block) {
  std::vector<std::string> keys;
  for (const RmsAxis& axis : kRmsAxes) keys.push_back(fmt::format("{}_{}", block, axis.key));
  return keys;
}

Rows rms_rows(const Measurement& figures, const std::array<std::string, 2>& names) {
  Rows rows;
  if (figures.rms) rows.push_back(figure_cells(figures, names[0], rms_keys("rms")));
  if (figures.rms_estimate) {
    rows.push_back(figure_cells(figures, names[1], rms_keys("rms_estimate")));
  }
  return rows;
}

Rows response_rows(const Measurement& figures) {
  Rows rows{{"Step"}};
  for (const Figure<StepResponse>& row : response_table()) {
    rows.front().push_back(fmt::format("{}, {}", row.title, row.unit));
  }
  for (const StepResponse& response : figures.responses) {
    rows.push_back({response.name});
    for (const Figure<StepResponse>& row : response_table()) {
      rows.back().push_back(fixed(row.get(response), row.digits));
    }
  }
  return rows;
}

Rows fault_rows(const std::vector<BenchFaultScript::Span>& faults,
                const std::vector<FaultThatNeverBegan>& never_began) {
  Rows rows{{"Fault", "begin s", "end s"}};
  for (const BenchFaultScript::Span& fault : faults) {
    rows.push_back({fault.name, fixed(base::to_seconds(fault.begin), 2),
                    fault.end ? fixed(base::to_seconds(*fault.end), 2) : "-"});
  }
  for (const FaultThatNeverBegan& fault : never_began) {
    rows.push_back({fault.name, "never", "-"});
  }
  return rows;
}

}  // namespace cas::hils
