// SPDX-License-Identifier: BSD-3-Clause
#include "hils/report/run_plots.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>
#include <numbers>
#include <span>

#include "base/angles.hpp"
#include "base/time/clock.hpp"
#include "hils/measure/gyro_record.hpp"
#include "hils/measure/tracking.hpp"
#include "hils/report/plugin_section.hpp"
#include "hils/report/spectrum.hpp"
#include "mavlink/common/hil_gps.hpp"
#include "mavlink/common/hil_sensor.hpp"

namespace cas::hils {

namespace {

using mavlink::common::HilGps;
using mavlink::common::HilSensor;

constexpr std::int64_t kReferencePeriodUs = 50'000;  ///< of a moving reference

using Direction = base::LedgerEntry::Direction;

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

/// The steps, the faults and the measured stretch, in each plot over time.
void add_marks(const RunRecord& record, StreamWindow window, NamedPlots& plots) {
  std::vector<Mark> marks = stage_marks(record.stages);
  for (const auto& fault : record.faults) {
    marks.push_back({.x = base::to_seconds(fault.begin), .text = fault.name, .fault = true});
    if (fault.end) marks.push_back({.x = base::to_seconds(*fault.end), .text = {}, .fault = true});
  }
  for (auto& [name, plot] : plots) {
    if (plot.x_label != kTimeLabel) continue;
    plot.marks = marks;
    plot.shaded = {seconds(window.begin_usec), seconds(window.end_usec)};
  }
}

void add_over_time(const char* name, const char* title, const char* y_label,
                   std::vector<Series> series, NamedPlots& plots, bool from_zero = false) {
  plots.emplace_back(name, Plot{.title = title,
                                .x_label = kTimeLabel,
                                .y_label = y_label,
                                .series = std::move(series),
                                .from_zero = from_zero});
}

void add_stream_plots(const RunRecord& record, const Measurement& figures, NamedPlots& plots) {
  const StreamFigures& rates = figures.rates;
  const std::uint32_t controls = controls_message_id(record);
  add_over_time(
      "rates", "Received per second, share of nominal", "%",
      {rate_series("HIL_SENSOR", record.controller, HilSensor::kId, rates.sensor.nominal_hz),
       rate_series("HIL_GPS", record.controller, HilGps::kId, rates.gps.nominal_hz),
       rate_series("controls", record.simulator, controls, rates.controls.nominal_hz)},
      plots, true);
  add_over_time("losses", "Lost per second", "packets",
                {loss_series("HIL_SENSOR", record.simulator, record.controller, HilSensor::kId),
                 loss_series("HIL_GPS", record.simulator, record.controller, HilGps::kId),
                 loss_series("controls", record.controller, record.simulator, controls)},
                plots, true);
  const StreamWindow window = figures.window;
  const RelayLedgers* relay = record.relay ? &*record.relay : nullptr;
  const auto add_hops = [&](const char* name, const char* title, const PacketPath& path,
                            const std::string& whole, std::vector<std::int64_t> whole_delays) {
    Plot plot{.title = title,
              .x_label = "us (what is below 1 counts as 1)",
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

/// A component of the pose over time, less `offset`, times `scale`.
Series pose_series(const std::string& name, const std::vector<PoseSample>& samples,
                   double Pose::*member, double offset, double scale = 1) {
  Series series{.name = name};
  for (const PoseSample& sample : samples) {
    series.points.emplace_back(static_cast<double>(sample.time_us) * 1e-6,
                               scale * (sample.pose.*member - offset));
  }
  return series;
}

/// A component of the reference that the steps set.
Series reference_series(const std::vector<Stage>& stages, double Pose::*member) {
  Series series{.name = "reference", .dashed = true};
  const auto add = [&](const Stage& stage, std::int64_t time_us) {
    series.points.emplace_back(1e-6 * static_cast<double>(time_us),
                               reference_at(stage, time_us).*member);
  };
  for (const Stage& stage : stages) {
    const std::int64_t begin = to_microseconds(stage.begin);
    const std::int64_t end = to_microseconds(stage.end);
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

/// Where a vehicle was, seen from above: east to the right, north upwards.
Series track_series(const std::string& name, std::span<const PoseSample> samples,
                    const Pose& start) {
  Series series{.name = name};
  for (const PoseSample& sample : samples) {
    series.points.emplace_back(sample.pose.y_m - start.y_m, sample.pose.x_m - start.x_m);
  }
  return series;
}

Series track_reference(const std::vector<Stage>& stages) {
  Series track = reference_series(stages, &Pose::y_m);
  const Series north = reference_series(stages, &Pose::x_m);
  for (std::size_t i = 0; i < track.points.size(); ++i) {
    track.points[i] = {track.points[i].second, north.points[i].second};
  }
  return track;
}

/// Samples per second, by their stamps.
double rate_of(std::int64_t first_us, std::int64_t last_us, std::size_t count) {
  if (last_us <= first_us) return 0;
  return 1e6 * static_cast<double>(count - 1) / static_cast<double>(last_us - first_us);
}

Series spectrum_series(const std::string& name, const Spectrum& spectrum, double scale) {
  Series series{.name = name};
  for (std::size_t i = 1; i < spectrum.amplitude.size(); ++i) {  // the mean was taken away
    series.points.emplace_back(static_cast<double>(i) * spectrum.resolution_hz,
                               scale * spectrum.amplitude[i]);
  }
  return series;
}

/// One spectrum for each component that `value(sample, component)` reads. Nothing where there are
/// too few samples in the window.
template <class Sample, class Value>
std::vector<Series> spectra(const std::vector<Sample>& all, StreamWindow window,
                            const std::vector<std::string>& names, double scale, Value value) {
  const auto begin = std::ranges::lower_bound(all, static_cast<std::int64_t>(window.begin_usec), {},
                                              &Sample::time_us);
  const auto end = std::ranges::upper_bound(all, static_cast<std::int64_t>(window.end_usec), {},
                                            &Sample::time_us);
  std::vector<Series> curves;
  if (end - begin < 2) return curves;
  const std::span<const Sample> samples(begin, end);
  const double rate_hz = rate_of(samples.front().time_us, samples.back().time_us, samples.size());
  for (std::size_t component = 0; component < names.size(); ++component) {
    std::vector<double> values;
    values.reserve(samples.size());
    for (const Sample& sample : samples) values.push_back(value(sample, component));
    const Spectrum spectrum = amplitude_spectrum(values, rate_hz);
    if (spectrum.amplitude.empty()) return {};
    curves.push_back(spectrum_series(names[component], spectrum, scale));
  }
  return curves;
}

/// Mean speed of the rotors in the window, turns per second.
double turns_per_second(const std::vector<PoseSample>& truth, StreamWindow window) {
  const auto samples = between(truth, static_cast<std::int64_t>(window.begin_usec),
                               static_cast<std::int64_t>(window.end_usec));
  double sum = 0;
  double count = 0;
  for (const PoseSample& sample : samples) {
    for (const double omega : sample.omega_rad_s) sum += omega;
    count += sample.rotors;
  }
  return count > 0 ? sum / count / (2 * std::numbers::pi) : 0;
}

std::vector<std::string> rotor_names(const std::vector<PoseSample>& truth) {
  std::vector<std::string> names;
  const int rotors = truth.empty() ? 0 : truth.front().rotors;
  for (int i = 1; i <= rotors; ++i) names.push_back(fmt::format("rotor {}", i));
  return names;
}

std::string spectrum_title(const std::string& of, const std::vector<Series>& curves) {
  const auto& points = curves.front().points;
  return fmt::format("Spectrum of the {}, measured stretch (to {:.0f} Hz in steps of {:.2f} Hz)",
                     of, points.back().first, points.front().first);
}

std::vector<GyroSample> gyro_of(const RunRecord& record) {
  if (record.sensors.empty()) return {};
  return read_gyro(record.sensors / "imu.csv");
}

void add_spectra(const RunRecord& record, const std::vector<PoseSample>& truth, StreamWindow window,
                 NamedPlots& plots) {
  const auto add = [&plots](const char* name, const std::string& of, const char* unit,
                            std::vector<Series> curves, std::vector<Mark> marks) {
    if (curves.empty()) return;
    const std::string title = spectrum_title(of, curves);
    plots.emplace_back(name, Plot{.title = title,
                                  .x_label = "Hz",
                                  .y_label = unit,
                                  .series = std::move(curves),
                                  .marks = std::move(marks),
                                  .log_y = true});
  };
  const double turns_hz = turns_per_second(truth, window);
  std::vector<Mark> marks;
  if (turns_hz > 0) {
    marks.push_back({.x = turns_hz, .text = fmt::format("rotors turn at {:.0f} Hz", turns_hz)});
  }
  add("gyro_spectrum", "gyro", "amplitude, deg/s",
      spectra(gyro_of(record), window, {"about forward", "about right", "about down"},
              base::kDegPerRad,
              [](const GyroSample& sample, std::size_t axis) { return sample.rate_rad_s[axis]; }),
      std::move(marks));
  add("motors_spectrum", "rotor speeds", "amplitude, rad/s",
      spectra(
          truth, window, rotor_names(truth), 1,
          [](const PoseSample& sample, std::size_t rotor) { return sample.omega_rad_s[rotor]; }),
      {});
}

void add_track(const RunRecord& record, const std::vector<PoseSample>& truth,
               const std::vector<PoseSample>& estimate, const Pose& start, NamedPlots& plots) {
  plots.emplace_back("track", Plot{.title = "Track from above, equal scales",
                                   .x_label = "east, m from the start",
                                   .y_label = "north, m from the start",
                                   .series = {track_series("truth", truth, start),
                                              track_series("estimate", estimate, Pose{}),
                                              track_reference(record.stages)},
                                   .equal_scales = true});
}

/// One curve for each component that `value(sample, component)` reads.
template <class Value>
std::vector<Series> time_series(const std::vector<PoseSample>& samples,
                                const std::vector<std::string>& names, Value value) {
  std::vector<Series> curves;
  for (std::size_t component = 0; component < names.size(); ++component) {
    Series series{.name = names[component]};
    for (const PoseSample& sample : samples) {
      series.points.emplace_back(static_cast<double>(sample.time_us) * 1e-6,
                                 value(sample, component));
    }
    curves.push_back(std::move(series));
  }
  return curves;
}

/// Position of truth, estimate and reference, an axis each.
void add_positions(const RunRecord& record, const std::vector<PoseSample>& truth,
                   const std::vector<PoseSample>& estimate, const Pose& start, NamedPlots& plots) {
  struct Axis {
    const char* name;
    const char* title;
    double Pose::*member;
  };
  for (const auto& [name, title, member] :
       {Axis{"position_x", "North", &Pose::x_m}, Axis{"position_y", "East", &Pose::y_m},
        Axis{"position_z", "Height", &Pose::z_m}}) {
    add_over_time(
        name, title, "m from the start",
        {pose_series("truth", truth, member, start.*member),
         pose_series("estimate", estimate, member, 0), reference_series(record.stages, member)},
        plots);
  }
}

void add_motion_plots(const RunRecord& record, StreamWindow window, NamedPlots& plots) {
  const std::vector<PoseSample>& truth = record.truth();
  const std::vector<PoseSample>& estimate = record.estimate();
  const Pose start = truth.empty() ? Pose{} : truth.front().pose;
  add_positions(record, truth, estimate, start, plots);
  add_track(record, truth, estimate, start, plots);
  add_over_time(
      "velocity", "Velocity (true)", "m/s",
      time_series(truth, {"north", "east", "up"},
                  [](const PoseSample& sample, std::size_t axis) { return sample.v_m_s[axis]; }),
      plots);
  add_over_time("heading", "Heading", "rad",
                {pose_series("truth", truth, &Pose::yaw_rad, 0),
                 pose_series("estimate", estimate, &Pose::yaw_rad, 0)},
                plots);
  add_over_time("attitude", "Attitude (true)", "deg",
                {pose_series("roll", truth, &Pose::roll_rad, 0, base::kDegPerRad),
                 pose_series("pitch", truth, &Pose::pitch_rad, 0, base::kDegPerRad),
                 pose_series("yaw", truth, &Pose::yaw_rad, 0, base::kDegPerRad)},
                plots);
  add_over_time("motors", "Rotor speeds", "rad/s",
                time_series(truth, rotor_names(truth),
                            [](const PoseSample& sample, std::size_t rotor) {
                              return sample.omega_rad_s[rotor];
                            }),
                plots);
  add_spectra(record, truth, window, plots);
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

RunCurves run_curves(const std::string& name, const Scenario& scenario, const RunRecord& record) {
  const std::vector<PoseSample>& truth = record.truth();
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

NamedPlots run_plots(const RunRecord& record, const Measurement& figures) {
  NamedPlots plots;
  add_motion_plots(record, figures.window, plots);
  if (figures.streamed) add_stream_plots(record, figures, plots);
  add_plugin_plots(figures.plugins, plots);
  add_marks(record, figures.window, plots);
  return plots;
}

}  // namespace cas::hils
