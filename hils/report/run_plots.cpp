// SPDX-License-Identifier: BSD-3-Clause
#include "hils/report/run_plots.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>

#include "base/time/clock.hpp"
#include "hils/measure/tracking.hpp"
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

using mavlink::common::HilGps;
using mavlink::common::HilSensor;
using Direction = base::LedgerEntry::Direction;

constexpr double kDegreesPerRadian = 180.0 / M_PI;
constexpr int kBucketsPerDecade = 20;

double seconds(std::uint64_t usec) { return static_cast<double>(usec) * 1e-6; }

Series loss_series(const std::string& name, const std::vector<base::LedgerEntry>& sender,
                   const std::vector<base::LedgerEntry>& receiver, std::uint32_t message_id) {
  Series series{.name = name, .steps = true};
  const auto sent = packets_per_second(sender, Direction::kSent, message_id);
  const auto received = packets_per_second(receiver, Direction::kReceived, message_id);
  for (const auto& [second, count] : sent) {
    const auto arrived = received.find(second);
    const int lost = count - (arrived == received.end() ? 0 : arrived->second);
    series.points.emplace_back(static_cast<double>(second), lost);
  }
  return series;
}

/// Share of the delays in logarithmic buckets, in percent.
Series delay_series(const std::string& name, const std::vector<std::int64_t>& delays_ns) {
  Series series{.name = name, .steps = true};
  std::map<int, std::size_t> buckets;
  for (const std::int64_t delay : delays_ns) {
    const double us = std::max(1.0, static_cast<double>(delay) / 1000.0);
    ++buckets[static_cast<int>(std::floor(std::log10(us) * kBucketsPerDecade))];
  }
  if (buckets.empty()) return series;
  const int last = buckets.rbegin()->first + 1;
  series.points.emplace_back(
      std::pow(10.0, static_cast<double>(buckets.begin()->first) / kBucketsPerDecade), 0);
  for (int bucket = buckets.begin()->first; bucket <= last; ++bucket) {
    const auto found = buckets.find(bucket);
    const double count = found == buckets.end() ? 0 : static_cast<double>(found->second);
    series.points.emplace_back(std::pow(10.0, static_cast<double>(bucket) / kBucketsPerDecade),
                               100.0 * count / static_cast<double>(delays_ns.size()));
  }
  return series;
}

std::vector<Mark> stage_marks(const std::vector<Stage>& stages) {
  std::vector<Mark> marks;
  for (const Stage& stage : stages) {
    if (phase_of(stage.step) == to_string(StepKind::kEndTrajectory)) continue;
    marks.push_back({.x = base::to_seconds(stage.begin),
                     .text = std::string(phase_of(stage.step)),
                     .fault = false});
  }
  return marks;
}

void add_stream_plots(const Scenario& scenario, const RunRecord& record, const Measurement& figures,
                      NamedPlots& plots) {
  const std::uint32_t controls = controls_message_id(record);
  plots.emplace_back(
      "rates",
      Plot{.title = "Received per second, share of nominal",
           .x_label = "simulated time, s",
           .y_label = "%",
           .series = {rate_series("HIL_SENSOR", record.controller, HilSensor::kId,
                                  scenario.rates.sensor_hz),
                      rate_series("HIL_GPS", record.controller, HilGps::kId, scenario.rates.gps_hz),
                      rate_series("controls", record.simulator, controls,
                                  scenario.rates.controls_hz)},
           .from_zero = true});
  plots.emplace_back(
      "losses",
      Plot{
          .title = "Lost per second",
          .x_label = "simulated time, s",
          .y_label = "packets",
          .series = {loss_series("HIL_SENSOR", record.simulator, record.controller, HilSensor::kId),
                     loss_series("HIL_GPS", record.simulator, record.controller, HilGps::kId),
                     loss_series("controls", record.controller, record.simulator, controls)},
          .from_zero = true});
  const StreamWindow window = figures.window;
  const RelayLedgers* relay = record.relay ? &*record.relay : nullptr;
  const auto add_hops = [&](const char* name, const char* title, const PacketPath& path,
                            const std::string& whole, std::vector<std::int64_t> whole_delays) {
    Plot plot{.title = title,
              .x_label = "us",
              .y_label = "% of the packets",
              .log_x = true,
              .from_zero = true};
    for (const auto& [hop, delays] :
         hop_delays(path, record.simulator, record.controller, relay, window)) {
      plot.series.push_back(delay_series(hop, delays));
    }
    plot.series.push_back(delay_series(whole, whole_delays));
    plots.emplace_back(name, std::move(plot));
  };
  add_hops("delays_up", "Delays of HIL_SENSOR by hop, measured stretch",
           {"HIL_SENSOR", HilSensor::kId, true}, "end to end",
           hop_delays_ns(record.simulator, record.controller, HilSensor::kId, window));
  add_hops("delays_down", "Delays of the controls by hop, measured stretch",
           {"controls", controls, false}, "loop",
           echo_delays_ns(record.simulator, HilSensor::kId, controls, window));
}

void add_motion_plots(const RunRecord& record, NamedPlots& plots) {
  const std::vector<PoseSample> truth = read_truth(record.truth_csv);
  const std::vector<PoseSample> estimate =
      read_estimate(record.flight_tlog, record.system, record.log_clock);
  const Pose start = truth.empty() ? Pose{} : truth.front().pose;
  struct Axis {
    const char* name;
    const char* title;
    double Pose::*member;
  };
  for (const Axis& axis :
       {Axis{"position_x", "North", &Pose::x_m}, Axis{"position_y", "East", &Pose::y_m},
        Axis{"position_z", "Height", &Pose::z_m}}) {
    plots.emplace_back(axis.name,
                       Plot{.title = axis.title,
                            .x_label = "simulated time, s",
                            .y_label = "m from the start",
                            .series = {pose_series("truth", truth, axis.member, start.*axis.member),
                                       pose_series("estimate", estimate, axis.member, 0),
                                       reference_series(record.stages, axis.member)}});
  }
  plots.emplace_back(
      "attitude",
      Plot{.title = "Attitude (true)",
           .x_label = "simulated time, s",
           .y_label = "deg",
           .series = {pose_series("roll", truth, &Pose::roll_rad, 0, kDegreesPerRadian),
                      pose_series("pitch", truth, &Pose::pitch_rad, 0, kDegreesPerRadian),
                      pose_series("yaw", truth, &Pose::yaw_rad, 0, kDegreesPerRadian)}});
  Plot motors{.title = "Rotor speeds", .x_label = "simulated time, s", .y_label = "rad/s"};
  for (std::size_t rotor = 0; rotor < 4; ++rotor) {
    Series series{.name = "rotor " + std::to_string(rotor + 1)};
    for (const PoseSample& sample : truth) {
      series.points.emplace_back(static_cast<double>(sample.time_us) * 1e-6,
                                 sample.omega_rad_s[rotor]);
    }
    motors.series.push_back(std::move(series));
  }
  plots.emplace_back("motors", std::move(motors));
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

NamedPlots run_plots(const Scenario& scenario, const RunRecord& record,
                     const Measurement& figures) {
  NamedPlots plots;
  add_motion_plots(record, plots);
  add_stream_plots(scenario, record, figures, plots);
  std::vector<Mark> marks = stage_marks(record.stages);
  for (const auto& fault : record.faults) {
    marks.push_back({.x = base::to_seconds(fault.begin), .text = fault.name, .fault = true});
    if (fault.end) marks.push_back({.x = base::to_seconds(*fault.end), .text = {}, .fault = true});
  }
  for (auto& [name, plot] : plots) {
    if (plot.log_x) continue;
    plot.marks = marks;
    plot.shaded = {seconds(figures.window.begin_usec), seconds(figures.window.end_usec)};
  }
  return plots;
}

}  // namespace cas::hils
