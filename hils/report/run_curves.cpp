// SPDX-License-Identifier: BSD-3-Clause
#include "hils/report/run_curves.hpp"

#include <map>

#include "base/time/clock.hpp"
#include "hils/measure/flight_reference.hpp"
#include "mavlink/common/hil_gps.hpp"
#include "mavlink/common/hil_sensor.hpp"

namespace cas::hils {

namespace {

using mavlink::common::HilGps;
using mavlink::common::HilSensor;

constexpr std::int64_t kReferencePeriodUs = 50'000;  ///< of a moving reference

std::int64_t microseconds(base::SimTime t) {
  return static_cast<std::int64_t>(base::to_time_usec(t));
}

}  // namespace

std::map<std::int64_t, int> packets_per_second(const std::vector<base::LedgerEntry>& ledger,
                                               base::LedgerEntry::Direction direction,
                                               std::uint32_t message_id) {
  std::map<std::int64_t, int> counts;
  for (const base::LedgerEntry& entry : ledger) {
    if (entry.direction == direction && entry.message_id == message_id) {
      ++counts[static_cast<std::int64_t>(entry.time_usec / 1'000'000)];
    }
  }
  return counts;
}

// Stamps (k, k + 1] s would be exact; the last second is not whole.
Series rate_series(const std::string& name, const std::vector<base::LedgerEntry>& ledger,
                   std::uint32_t message_id, double nominal_hz) {
  Series series{.name = name, .steps = true};
  auto counts = packets_per_second(ledger, base::LedgerEntry::Direction::kReceived, message_id);
  if (!counts.empty()) counts.erase(std::prev(counts.end()));
  for (const auto& [second, count] : counts) {
    series.points.emplace_back(static_cast<double>(second), 100.0 * count / nominal_hz);
  }
  return series;
}

Series pose_series(const std::string& name, const std::vector<PoseSample>& samples,
                   double Pose::*member, double offset, double scale) {
  Series series{.name = name};
  for (const PoseSample& sample : samples) {
    series.points.emplace_back(static_cast<double>(sample.time_us) * 1e-6,
                               scale * (sample.pose.*member - offset));
  }
  return series;
}

Series reference_series(const std::vector<Stage>& stages, double Pose::*member) {
  Series series{.name = "reference", .dashed = true};
  const auto add = [&](const Stage& stage, std::int64_t time_us) {
    series.points.emplace_back(1e-6 * static_cast<double>(time_us),
                               reference_at(stage, time_us).*member);
  };
  for (const Stage& stage : stages) {
    const std::int64_t begin = microseconds(stage.begin);
    const std::int64_t end = microseconds(stage.end);
    add(stage, begin);
    if (stage.step.kind == StepKind::kTrajectory) {
      for (std::int64_t t = begin + kReferencePeriodUs; t < end; t += kReferencePeriodUs) {
        add(stage, t);
      }
    }
    add(stage, end);
  }
  return series;
}

RunCurves run_curves(const std::string& name, const Scenario& scenario, const RunRecord& record) {
  const std::vector<PoseSample> truth = read_truth(record.truth_csv);
  const Pose start = truth.empty() ? Pose{} : truth.front().pose;
  return {
      .sensor_rate = rate_series(name, record.controller, HilSensor::kId, scenario.rates.sensor_hz),
      .gps_rate = rate_series(name, record.controller, HilGps::kId, scenario.rates.gps_hz),
      .controls_rate = rate_series(name, record.simulator, controls_message_id(record),
                                   scenario.rates.controls_hz),
      .x = pose_series(name, truth, &Pose::x_m, start.x_m),
      .y = pose_series(name, truth, &Pose::y_m, start.y_m),
      .z = pose_series(name, truth, &Pose::z_m, start.z_m),
      .yaw = pose_series(name, truth, &Pose::yaw_rad, 0),
      .x_reference = reference_series(record.stages, &Pose::x_m),
      .y_reference = reference_series(record.stages, &Pose::y_m),
      .z_reference = reference_series(record.stages, &Pose::z_m),
  };
}

}  // namespace cas::hils
