// SPDX-License-Identifier: BSD-3-Clause
#include "hils/report/figure_rows.hpp"

#include <fmt/format.h>

#include <initializer_list>

#include "base/time/clock.hpp"
#include "hils/report/experiment.hpp"
#include "hils/report/number_text.hpp"
#include "hils/report/paper_figures.hpp"

namespace cas::hils {

namespace {

std::vector<std::string> row_of(const std::string& name, std::initializer_list<double> values) {
  std::vector<std::string> row{name};
  for (const double value : values) row.push_back(fixed(value, 4));
  return row;
}

}  // namespace

Rows rate_rows(const Measurement& figures) {
  const auto& [sensor, gps, controls] = figures.rates;
  Rows rows{row_of(title_of(figures.architecture),
                   {sensor.received_hz, sensor.error_pct, gps.received_hz, gps.error_pct,
                    controls.received_hz, controls.error_pct})};
  for (const PaperRates& paper : kPaperTable4) {
    rows.push_back(row_of(fmt::format("[HILS] {}", paper.name),
                          {paper.sensor_hz, paper.sensor_error_pct, paper.gps_hz,
                           paper.gps_error_pct, paper.controls_hz, paper.controls_error_pct}));
  }
  return rows;
}

std::vector<std::string> rms_cells(const std::optional<RmsFigures>& rms) {
  std::vector<std::string> cells;
  cells.reserve(kRmsAxes.size());
  for (const RmsAxis& axis : kRmsAxes) {
    cells.push_back(rms ? fixed(*rms.*axis.member, 4) : "-");
  }
  return cells;
}

void add_delay_cells(const DelayFigures& delay,
                     std::initializer_list<double DelayFigures::*> figures,
                     std::vector<std::string>& row) {
  for (const auto member : figures) row.push_back(delay.count > 0 ? fixed(delay.*member, 0) : "-");
}

Rows rms_rows(const Measurement& figures, const std::array<std::string, 2>& names) {
  Rows rows;
  for (const auto& [name, rms] :
       {std::pair{&names[0], &figures.rms}, std::pair{&names[1], &figures.rms_estimate}}) {
    if (*rms)
      rows.push_back(row_of(*name, {(*rms)->x_m, (*rms)->y_m, (*rms)->z_m, (*rms)->yaw_rad}));
  }
  if (!measures_station_keeping(figures)) return rows;
  for (const PaperRms& paper : kPaperTable5) {
    rows.push_back(row_of(fmt::format("[HILS] {}", paper.name),
                          {paper.x_m, paper.y_m, paper.z_m, paper.yaw_rad}));
  }
  return rows;
}

Rows response_rows(const Measurement& figures) {
  Rows rows;
  for (const StepResponse& response : figures.responses) {
    rows.push_back({response.name, fixed(response.size, 2), fixed(response.rise_s, 2),
                    fixed(response.overshoot_pct, 1), fixed(response.settling_s, 2),
                    fixed(response.integrated_error, 3)});
  }
  return rows;
}

Rows fault_rows(const Measurement& figures) {
  Rows rows;
  for (const auto& fault : figures.faults) {
    rows.push_back({fault.name, fixed(base::to_seconds(fault.begin), 2),
                    fault.end ? fixed(base::to_seconds(*fault.end), 2) : "-"});
  }
  for (const FaultThatNeverBegan& fault : figures.never_began) {
    rows.push_back({fault.name, "never", "-"});
  }
  return rows;
}

}  // namespace cas::hils
