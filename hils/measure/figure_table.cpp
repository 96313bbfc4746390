// SPDX-License-Identifier: BSD-3-Clause
#include "hils/measure/figure_table.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <utility>

namespace cas::hils {
namespace {

using FigureRow = Figure<Measurement>;
using FigureRows = std::vector<FigureRow>;
using enum Better;

/// Firmware in software has no figures of its HIL stream.
std::function<std::optional<double>(const Measurement&)> where_streamed(
    std::function<std::optional<double>(const Measurement&)> get) {
  return [get = std::move(get)](const Measurement& m) -> std::optional<double> {
    return m.streamed ? get(m) : std::nullopt;
  };
}

void add(FigureRow::Part part, FigureRows rows, FigureRows& table) {
  for (FigureRow& row : rows) {
    row.part = part;
    if (part == FigureRow::Part::kStream) row.get = where_streamed(std::move(row.get));
    table.push_back(std::move(row));
  }
}

/// Reads a member of a Measurement.
template <class Member>
auto of(Member Measurement::*member) {
  return [member](const Measurement& m) -> std::optional<double> { return m.*member; };
}

auto pace(double PaceFigures::*member) {
  return [member](const Measurement& m) -> std::optional<double> { return m.pace.*member; };
}

auto clearance(double TerrainClearance::*member) {
  return [member](const Measurement& m) -> std::optional<double> {
    return m.clearance ? std::optional(*m.clearance.*member) : std::nullopt;
  };
}

std::optional<double> casd_cpu_pct(const Measurement& figures) {
  std::optional<double> sum_s;
  for (const auto& [program, seconds] : figures.cpu_s) {
    if (program == "casd") sum_s = sum_s.value_or(0) + seconds;
  }
  if (!sum_s || figures.wall_s <= 0) return std::nullopt;
  return 100 * *sum_s / figures.wall_s;
}

std::optional<double> slowest_way_us(const Measurement& figures) {
  if (!figures.firmware) return std::nullopt;
  return slowest_hop_us(nlohmann::json::parse(figures.firmware->hops));
}

// The table.

void add_run(FigureRows& table) {
  add(FigureRow::Part::kRun,
      {{"real_time_factor", "real-time factor", "", 4, kUp, "simulated over elapsed time",
        pace(&PaceFigures::real_time_factor)},
       {"worst_stall_ms", "longest stall of the simulation", "ms", 1, kDown,
        "most that HIL_SENSOR fell behind its own stamps within a second",
        where_streamed(pace(&PaceFigures::worst_stall_ms))},
       {"late_p99_ms", "HIL_SENSOR sent late, 99 %", "ms", 2, kDown,
        "lag of HIL_SENSOR behind its own stamps", where_streamed(pace(&PaceFigures::late_p99_ms))},
       {"handover_p99_us", "handover between simulator and casd, 99 %", "us", 0, kDown,
        "the slowest UDP hop; not of `ts`, where it waits for the line",
        of(&Measurement::handover_p99_us)},
       {"reading_spread_us", "HIL_SENSOR read by the controller, 99 % less the median", "us", 0,
        kDown, "from casd's write to the controller's read; not of `ts`",
        of(&Measurement::reading_spread_us)},
       {"paused_ms", "pauses of a hop between two programs", "ms", 1, kDown,
        "time for which packets were held up by 25 ms or more, at the hop that paused most; "
        "not of `ts`",
        of(&Measurement::paused_ms)},
       {"hop_p99_us", "slowest way through casd, 99 %", "us", 0, kDown,
        "from one link's read to another's write; of stock firmware", slowest_way_us},
       {"port_gap_ms", "longest gap of HIL_SENSOR at the controller's port", "ms", 1, kDown,
        "where stock firmware is flown in HITL", of(&Measurement::port_gap_ms)},
       {"cpu_pressure", "pressure on the processors", "", 3, kDown,
        "share of the measurement in which a task waited for a processor (`/proc/pressure/cpu`)",
        of(&Measurement::cpu_pressure)},
       {"casd_cpu_pct", "processor time of casd", "%", 2, kDown, "of one processor", casd_cpu_pct},
       {"simulated_s", "simulated time", "s", 1, kNeither, "length of the run",
        of(&Measurement::simulated_s)},
       {"wall_s", "elapsed time", "s", 2, kNeither, "that the run took", of(&Measurement::wall_s)}},
      table);
}

void add_rate(const Stream& stream, FigureRows& table) {
  const auto rate = [member = stream.rate](auto RateFigures::*figure) {
    return [=](const Measurement& m) -> std::optional<double> {
      return static_cast<double>(m.rates.*member.*figure);
    };
  };
  const auto delivered_pct = [member = stream.rate](const Measurement& m) -> std::optional<double> {
    const RateFigures& figures = m.rates.*member;
    if (figures.sent == 0) return std::nullopt;
    return 100.0 * static_cast<double>(figures.received) / static_cast<double>(figures.sent);
  };
  const auto meter_hz = [member = stream.meter_hz](const Measurement& m) -> std::optional<double> {
    return m.meter.*member;
  };
  FigureRows rows{
      {"_nominal_hz", "nominal rate", "Hz", 1, kNeither, "of the scenario",
       rate(&RateFigures::nominal_hz), "nominal_hz"},
      {"_sent", "sent", "packets", 0, kNeither, "with stamps in the window",
       rate(&RateFigures::sent), "sent"},
      {"_received", "received", "packets", 0, kNeither, "of those sent, however late",
       rate(&RateFigures::received), "received"},
      {"_lost", "lost", "packets", 0, kDown, "of those sent", rate(&RateFigures::lost), "lost"},
      {"_delivered_pct", "delivered", "%", 3, kUp, "received, of those sent", delivered_pct,
       "delivered_pct"},
      {"_hz", "received rate", "Hz", 4, kNeither, "by the receiver's clock",
       rate(&RateFigures::received_hz), "received_hz"},
      {"_rate_error_pct", "rate error", "%", 4, kNeither,
       "how far the received rate falls short of the nominal one; negative above it",
       rate(&RateFigures::error_pct), "error_pct"},
      {"_meter_hz", "averaging meter", "Hz", 3, kNeither,
       "reading of QGroundControl 3's averaging meter at the end of the window", meter_hz}};
  for (FigureRow& row : rows) {
    row.key = fmt::format("{}{}", stream.key, row.key);
    row.title = fmt::format("{} {}", stream.name, row.title);
    row.path = row.path.empty() ? fmt::format("meter_hz.{}", stream.name)
                                : fmt::format("rates.{}.{}", stream.name, row.path);
  }
  add(FigureRow::Part::kStream, std::move(rows), table);
}

void add_delay(const Delay& delay, FigureRows& table) {
  const auto figure = [which = delay.figures](auto DelayFigures::*member) {
    return [=](const Measurement& m) -> std::optional<double> {
      const DelayFigures& figures = m.*which;
      if (figures.count == 0) return std::nullopt;
      return static_cast<double>(figures.*member);
    };
  };
  const std::string meaning(delay.meaning);
  FigureRows rows{
      {"_count", "packets", "packets", 0, kNeither, "those that were timed",
       figure(&DelayFigures::count), "count"},
      {"_p50_us", "median", "us", 0, kDown, meaning, figure(&DelayFigures::p50), "p50"},
      {"_p90_us", "90 %", "us", 0, kDown, meaning, figure(&DelayFigures::p90), "p90"},
      {"_p99_us", "99 %", "us", 0, kDown, meaning, figure(&DelayFigures::p99), "p99"},
      {"_max_us", "longest", "us", 0, kDown, meaning, figure(&DelayFigures::max), "max"}};
  for (FigureRow& row : rows) {
    row.key = fmt::format("{}{}", delay.key, row.key);
    row.title = fmt::format("{}, {}", delay.title, row.title);
    row.path = fmt::format("{}.{}", delay.path, row.path);
  }
  add(FigureRow::Part::kStream, std::move(rows), table);
}

void add_rms(std::string_view block, std::string_view what, std::string_view meaning,
             std::optional<RmsFigures> Measurement::*rms, FigureRows& table) {
  FigureRows rows;
  for (const RmsAxis& axis : kRmsAxes) {
    rows.push_back({fmt::format("{}_{}", block, axis.key),
                    fmt::format("RMS error of the {}, {}", what, axis.key), std::string(axis.unit),
                    4, kDown, std::string(meaning),
                    [rms, member = axis.member](const Measurement& m) -> std::optional<double> {
                      if (!(m.*rms)) return std::nullopt;
                      // Not-a-number: there was no reference.
                      const double value = *(m.*rms).*member;
                      return std::isnan(value) ? std::nullopt : std::optional(value);
                    },
                    fmt::format("{}.{}", block, axis.key)});
  }
  add(FigureRow::Part::kMotion, std::move(rows), table);
}

void add_motion(FigureRows& table) {
  add_rms("rms", "true position", "against the reference, in the measured step", &Measurement::rms,
          table);
  add_rms("rms_estimate", "estimate",
          "of the controller itself, from the place of arming, against the reference, in the "
          "measured step",
          &Measurement::rms_estimate, table);
  add(FigureRow::Part::kMotion,
      {{"rms_position_m", "RMS error of the true position", "m", 4, kDown,
        "distance from the reference in space, in the measured step",
        [](const Measurement& m) -> std::optional<double> {
          if (!m.rms) return std::nullopt;
          return std::hypot(m.rms->x_m, m.rms->y_m, m.rms->z_m);
        }},
       {"peak_error_m", "largest error of the true position", "m", 3, kDown,
        "farthest from the reference at any moment of the measured step",
        of(&Measurement::peak_error_m)},
       {"height_error_m", "error of the mean height", "m", 3, kDown,
        "mean true height of the measured hold against the plan's; not of a trajectory. A swing "
        "about the mean does not show in it",
        of(&Measurement::height_error_m)},
       {"drift_m", "drift", "m", 3, kDown,
        "farthest horizontal distance of the true position from where the measured hold began; "
        "not of a trajectory",
        of(&Measurement::drift_m)},
       {"radius_error_pct", "error of the circle's radius", "%", 3, kDown,
        "mean true distance from the middle of the circle against its radius, in a measured hold "
        "after `loiter`",
        of(&Measurement::radius_error_pct)},
       {"least_airspeed_m_s", "least airspeed", "m/s", 2, kUp,
        "true airspeed in the measured step, of a vehicle with plugin airspeed",
        of(&Measurement::least_airspeed_m_s)},
       {"transition_height_m", "height in transitions", "m", 3, kDown,
        "the most that a `transition` of a VTOL changed the true height",
        of(&Measurement::transition_height_m)},
       {"landing_error_m", "error of the landing", "m", 3, kDown,
        "true horizontal distance from where `land` was begun, of a vehicle that hung still then; "
        "of a plane from where it took off",
        of(&Measurement::landing_error_m)},
       {"beacon_error_m", "distance from the beacon", "m", 3, kDown,
        "true horizontal distance at the end of the run, of a vehicle with plugin landing_target",
        of(&Measurement::beacon_error_m)},
       {"sticks_way_m", "way by the sticks", "m", 2, kUp,
        "true horizontal distance from the begin to the end of the last `sticks`",
        of(&Measurement::sticks_way_m)},
       {"least_clearance_m", "least height above the terrain", "m", 2, kUp,
        "true, between the first and the last waypoint `above: terrain` of a mission",
        clearance(&TerrainClearance::least_m)},
       {"most_clearance_m", "greatest height above the terrain", "m", 2, kDown,
        "as `least_clearance_m`", clearance(&TerrainClearance::most_m)},
       {"rotor_activity_rad_s2", "activity of the rotors", "rad/s^2", 1, kDown,
        "RMS of the rotors' accelerations in the measured step, from sample to sample of "
        "`truth.csv` (100 Hz): a measure of control activity",
        of(&Measurement::rotor_activity_rad_s2)}},
      table);
}

FigureRows make_table() {
  FigureRows table;
  add_run(table);
  for (const Stream& stream : kStreams) add_rate(stream, table);
  for (const Delay& delay : kDelays) add_delay(delay, table);
  add_motion(table);
  return table;
}

// Reference

/// A table of the rows. Neighbours with one meaning and unit, like the percentiles of a delay,
/// share a line.
template <class Of>
std::string reference(const std::vector<Figure<Of>>& table) {
  std::vector<Figure<Of>> lines;
  for (const Figure<Of>& row : table) {
    if (lines.empty() || row.meaning != lines.back().meaning || row.unit != lines.back().unit) {
      lines.push_back(row);
      continue;
    }
    Figure<Of>& line = lines.back();
    line.key += "`, `" + row.key;
    line.path += "`, `" + row.path;
    line.title = line.title.substr(0, line.title.find_last_of(','));
  }
  std::string text =
      "| key | figure | unit | better | meaning | in summary.json |\n|---|---|---|---|---|---|\n";
  for (const Figure<Of>& row : lines) {
    const char* const better = row.better == kUp ? "up" : row.better == kDown ? "down" : "";
    text += fmt::format("| `{}` | {} | {} | {} | {} | {} |\n", row.key, row.title, row.unit, better,
                        row.meaning, row.path.empty() ? "" : fmt::format("`{}`", row.path));
  }
  return text;
}

}  // namespace

const std::vector<Figure<Measurement>>& figure_table() {
  static const FigureRows kTable = make_table();
  return kTable;
}

const std::vector<Figure<StepResponse>>& response_table() {
  using R = const StepResponse&;
  static const std::vector<Figure<StepResponse>> kTable{
      {"size_m", "size", "m", 2, kNeither, "of the step", [](R r) { return r.size; }},
      {"rise_s", "rise time", "s", 2, kDown, "from 10 to 90 %", [](R r) { return r.rise_s; }},
      {"overshoot_pct", "overshoot", "%", 1, kDown, "beyond the new value, of the step's size",
       [](R r) { return r.overshoot_pct; }},
      {"settling_s", "settling time", "s", 2, kDown, "to within 5 % for good",
       [](R r) { return r.settling_s; }},
      {"integrated_error_m_s", "integrated error", "m s", 3, kDown,
       "integral of the absolute error", [](R r) { return r.integrated_error; }}};
  return kTable;
}

const Figure<Measurement>& figure_row(std::string_view key) {
  const auto row = std::ranges::find(figure_table(), key, &FigureRow::key);
  if (row == figure_table().end()) throw std::logic_error(fmt::format("no figure '{}'", key));
  return *row;
}

std::string figure_reference() {
  FigureRows own;
  add_run(own);
  for (const Delay& delay : kDelays) add_delay(delay, own);
  add_motion(own);
  FigureRows streams;
  add_rate({"KEY", "MESSAGE", &StreamFigures::sensor, &MeterReadings::sensor_hz}, streams);
  std::string keys;
  for (const Stream& stream : kStreams) {
    keys += fmt::format("{}`{}` is {}", keys.empty() ? "" : ", ", stream.key, stream.name);
  }
  return reference(own) + fmt::format("\nOf each HIL message, under three KEYs: {}:\n\n", keys) +
         reference(streams) +
         "\nOf each `trajectory: {shape: step}`; in tables its name is in front: "
         "`NAME_rise_s`:\n\n" +
         reference(response_table());
}

}  // namespace cas::hils
