// SPDX-License-Identifier: BSD-3-Clause
#include "hils/measurement.hpp"

#include <algorithm>

#include "base/clock.hpp"
#include "base/vehicle.hpp"
#include "mavlink/common/hil_actuator_controls.hpp"
#include "mavlink/common/hil_controls.hpp"
#include "mavlink/common/hil_gps.hpp"
#include "mavlink/common/hil_sensor.hpp"

namespace cas::hils {

namespace {

using mavlink::common::HilActuatorControls;
using mavlink::common::HilControls;
using mavlink::common::HilGps;
using mavlink::common::HilSensor;

constexpr std::uint64_t kTailUsec = 500'000;  ///< left out where there is no hold to measure

StreamWindow whole_stream(const RunRecord& record) {
  std::uint64_t last = 0;
  for (const base::LedgerEntry& entry : record.simulator) last = std::max(last, entry.time_usec);
  return {.begin_usec = 0, .end_usec = last > kTailUsec ? last - kTailUsec : 0};
}

StreamWindow window_of(const Stage& hold) {
  return {.begin_usec = base::to_time_usec(hold.begin), .end_usec = base::to_time_usec(hold.end)};
}

/// The reference in the axes of truth.csv: the plan's places count from where the vehicle stood.
Pose reference_in_truth(const Stage& hold, std::span<const PoseSample> truth) {
  Pose start;
  if (!truth.empty()) start = truth.front().pose;
  return {.x_m = start.x_m + hold.reference_m.x(),
          .y_m = start.y_m + hold.reference_m.y(),
          .z_m = start.z_m + hold.reference_m.z(),
          .yaw_rad = hold.reference_yaw_rad};
}

Pose reference_in_estimate(const Stage& hold) {
  return {.x_m = hold.reference_m.x(),
          .y_m = hold.reference_m.y(),
          .z_m = hold.reference_m.z(),
          .yaw_rad = hold.reference_yaw_rad};
}

std::int64_t microseconds(base::SimTime t) {
  return static_cast<std::int64_t>(base::to_time_usec(t));
}

void measure_hold(const RunRecord& record, std::uint8_t system, Measurement& figures) {
  const Stage& hold = *record.hold;
  const std::int64_t begin = microseconds(hold.begin);
  const std::int64_t end = microseconds(hold.end);
  const std::vector<PoseSample> truth = read_truth(record.truth_csv);
  figures.rms = rms_about(between(truth, begin, end), reference_in_truth(hold, truth));
  const std::vector<PoseSample> estimate =
      read_estimate(record.flight_tlog, system, record.log_clock);
  const auto in_hold = between(estimate, begin, end);
  if (!in_hold.empty()) figures.rms_estimate = rms_about(in_hold, reference_in_estimate(hold));
}

void measure_stream(const Scenario& scenario, const RunRecord& record, Measurement& figures) {
  const std::uint32_t controls_id = controls_message_id(record);
  const auto& [simulator, controller] = std::tie(record.simulator, record.controller);
  const StreamWindow window = figures.window;
  figures.rates.sensor =
      account(simulator, controller, HilSensor::kId, window, scenario.rates.sensor_hz);
  figures.rates.gps = account(simulator, controller, HilGps::kId, window, scenario.rates.gps_hz);
  figures.rates.controls =
      account(controller, simulator, controls_id, window, scenario.rates.controls_hz);
  figures.sensor_to_control =
      summarise(echo_delays_ns(simulator, HilSensor::kId, controls_id, window));
  figures.sensor_uplink = summarise(hop_delays_ns(simulator, controller, HilSensor::kId, window));
  figures.controls_downlink = summarise(hop_delays_ns(controller, simulator, controls_id, window));
  figures.pace = pace(simulator, HilSensor::kId, window);
}

}  // namespace

std::uint32_t controls_message_id(const RunRecord& record) {
  const bool outputs = std::ranges::any_of(record.controller, [](const base::LedgerEntry& entry) {
    return entry.message_id == HilActuatorControls::kId;
  });
  return outputs ? HilActuatorControls::kId : HilControls::kId;
}

Measurement measure(const RunRequest& request, const RunRecord& record) {
  const Scenario& scenario = request.scenario;
  Measurement figures;
  figures.scenario = scenario.name;
  figures.architecture = request.architecture;
  figures.seed = request.seed;
  figures.virtual_clock = record.virtual_clock;
  figures.flight_failure = record.flight_failure;
  figures.simulated_s = record.simulated_s;
  figures.wall_s = record.wall_s;
  figures.cpu_s = record.cpu_s;
  figures.cpu_pressure = record.cpu_pressure;
  figures.stages = record.stages;
  figures.over_hold = record.hold.has_value();
  figures.window = record.hold ? window_of(*record.hold) : whole_stream(record);
  measure_stream(scenario, record, figures);
  if (record.virtual_clock && record.wall_s > 0) {
    figures.pace.real_time_factor = record.simulated_s / record.wall_s;
  }
  if (record.hold) {
    const base::Vehicle vehicle = base::Vehicle::load(scenario.vehicle);
    measure_hold(record, vehicle.system_id, figures);
  }
  return figures;
}

}  // namespace cas::hils
