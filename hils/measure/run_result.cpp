// SPDX-License-Identifier: BSD-3-Clause
#include "hils/measure/run_result.hpp"

#include <algorithm>
#include <utility>

namespace cas::hils {

Measurement RunResult::whole() const {
  Measurement whole = vehicles.front().figures;
  for (const VehicleResult& vehicle : vehicles) {
    const PaceFigures& pace = vehicle.figures.pace;
    whole.pace.real_time_factor = std::min(whole.pace.real_time_factor, pace.real_time_factor);
    whole.pace.worst_stall_ms = std::max(whole.pace.worst_stall_ms, pace.worst_stall_ms);
    whole.pace.late_p99_ms = std::max(whole.pace.late_p99_ms, pace.late_p99_ms);
    whole.reading_spread_us = std::max(whole.reading_spread_us, vehicle.figures.reading_spread_us);
    whole.handover_p99_us = std::max(whole.handover_p99_us, vehicle.figures.handover_p99_us);
    whole.paused_ms = std::max(whole.paused_ms, vehicle.figures.paused_ms);
  }
  return whole;
}

RunResult evaluate(const RunRequest& request, std::vector<RunRecord> records) {
  RunResult run;
  for (RunRecord& record : records) {
    VehicleResult& vehicle = run.vehicles.emplace_back();
    vehicle.record = std::move(record);
    vehicle.figures = measure(request, vehicle.record);
    vehicle.verdict = judge(vehicle.figures, request.scenario.limits_of(run.vehicles.size() - 1));
  }
  run.verdict = run.has_several() ? judge_together(run.vehicles) : run.vehicles.front().verdict;
  return run;
}

Verdict judge_together(const std::vector<VehicleResult>& vehicles) {
  Verdict together{.valid = true, .passed = true, .failures = {}};
  for (const VehicleResult& vehicle : vehicles) {
    merge_verdict(vehicle.figures.vehicle, vehicle.verdict, together);
  }
  return together;
}

}  // namespace cas::hils
