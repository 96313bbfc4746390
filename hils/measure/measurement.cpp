// SPDX-License-Identifier: BSD-3-Clause
#include "hils/measure/measurement.hpp"

#include <fmt/format.h>
#include <algorithm>
#include <filesystem>
#include <iterator>
#include <span>

#include "base/time/clock.hpp"
#include "casd/station/gain_map.hpp"
#include "hils/measure/hold_motion.hpp"
#include "hils/measure/packet_account.hpp"
#include "hils/measure/step_figures.hpp"
#include "hils/measure/struck_object.hpp"
#include "hils/measure/tracking.hpp"
#include "hils/measure/true_steps.hpp"
#include "mavlink/common/hil_gps.hpp"
#include "mavlink/common/hil_sensor.hpp"
#include "plugins/fault/fault_spec.hpp"

namespace cas::hils {

namespace {

using mavlink::common::HilGps;
using mavlink::common::HilSensor;

/// 50 samples of the recorder. A vehicle that falls for this long exceeds kCrashSpeed_m_s.
constexpr std::int64_t kHole_us = 500'000;

double seconds(std::int64_t time_us) { return 1e-6 * static_cast<double>(time_us); }

/// Finds a gap of 0.5 s or longer in the record of the true flight, from the begin of the first
/// step to the end of the last one. Incidents in a gap are not seen.
///
/// @param stages  the flight as it went, with the step under way
/// @return a sentence without a full stop; nullopt: the record has no gap
std::optional<std::string> record_hole(const std::vector<Stage>& stages,
                                       std::span<const PoseSample> truth) {
  if (stages.empty()) return std::nullopt;
  if (truth.empty()) return "it is empty";
  const std::int64_t begin_us = to_microseconds(stages.front().begin);
  const std::int64_t end_us = to_microseconds(stages.back().end);
  if (truth.front().time_us - begin_us >= kHole_us) {
    return fmt::format("it begins at {:.2f} s, and the flight at {:.2f} s",
                       seconds(truth.front().time_us), seconds(begin_us));
  }
  std::int64_t before_us = truth.front().time_us;
  for (const PoseSample& sample : truth) {
    if (sample.time_us < before_us) {
      return fmt::format("its time goes back, from {:.2f} s to {:.2f} s", seconds(before_us),
                         seconds(sample.time_us));
    }
    const bool in_flight = sample.time_us > begin_us && before_us < end_us;
    if (in_flight && sample.time_us - before_us >= kHole_us) {
      return fmt::format("it has nothing between {:.2f} s and {:.2f} s", seconds(before_us),
                         seconds(sample.time_us));
    }
    before_us = sample.time_us;
  }
  if (end_us - before_us < kHole_us) return std::nullopt;
  return fmt::format("it ends at {:.2f} s, and the flight at {:.2f} s", seconds(before_us),
                     seconds(end_us));
}

/// Left out where there is no hold to measure: the time in which the pipe is drained (kDrainUsec of
/// packet_account.cpp), and as much again, because stamps of controls over a slow line are old.
constexpr std::uint64_t kTailUsec = 1'000'000;

StreamWindow whole_stream(const RunRecord& record) {
  std::uint64_t last = 0;
  for (const base::LedgerEntry& entry : record.simulator) last = std::max(last, entry.time_usec);
  return {.begin_usec = 0, .end_usec = last > kTailUsec ? last - kTailUsec : 0};
}

StreamWindow window_of(const Stage& hold) {
  return {.begin_usec = base::to_time_usec(hold.begin), .end_usec = base::to_time_usec(hold.end)};
}

/// The meter starts with the stream and is read at the end of the window.
double meter_hz(const std::vector<base::LedgerEntry>& ledger, std::uint32_t message_id,
                StreamWindow window) {
  std::vector<std::int64_t> arrivals;
  for (const base::LedgerEntry& entry : ledger) {
    if (entry.direction == base::LedgerEntry::Direction::kReceived &&
        entry.message_id == message_id && entry.time_usec <= window.end_usec) {
      arrivals.push_back(entry.at_ns);
    }
  }
  return arrivals.empty() ? 0 : averaging_meter_hz(arrivals, arrivals.back());
}

/// Delays that need controls to carry the stamp of the sample they were computed from.
void measure_echoes(const std::vector<base::LedgerEntry>& simulator,
                    const std::vector<base::LedgerEntry>& controller, std::uint32_t controls_id,
                    Measurement& figures) {
  using enum base::LedgerEntry::Direction;
  const StreamWindow window = figures.window;
  figures.sensor_to_control =
      summarise(echo_delays_ns(simulator, HilSensor::kId, controls_id, window));
  figures.age_by_stamp = summarise(
      delays_ns({simulator, kSent, HilSensor::kId}, {controller, kSent, controls_id}, window));
  figures.age_by_arrival = summarise(
      delays_ns({controller, kReceived, HilSensor::kId}, {controller, kSent, controls_id}, window));
}

/// The UDP hops between simulator and casd, where nothing but the machine takes time.
std::optional<double> handover_p99_us(const std::vector<PathAccount>& paths) {
  constexpr std::size_t kHopsThroughCasd = 3;
  constexpr std::size_t kLeastForAShareOf1Percent = 200;  // of fewer it is the longest one
  std::optional<double> slowest;
  for (const PathAccount& path : paths) {
    if (path.hops.size() != kHopsThroughCasd) continue;
    for (const HopFigures& hop : {path.hops.front(), path.hops.back()}) {
      if (hop.delay.count < kLeastForAShareOf1Percent) continue;
      if (hop.from == HopPoint::kSimulator || hop.to == HopPoint::kSimulator) {
        slowest = std::max(slowest.value_or(0), hop.delay.p99);
      }
    }
  }
  return slowest;
}

/// Pauses of the hop that paused most. Within casd a packet waits for those before it, not for the
/// machine.
std::optional<double> paused_ms(const std::vector<PathAccount>& paths) {
  std::optional<double> most;
  for (const PathAccount& path : paths) {
    for (const HopFigures& hop : path.hops) {
      if (path.hops.size() > 1 && hop.from != HopPoint::kCasdIn)
        most = std::max(most.value_or(0), hop.paused_ms);
    }
  }
  return most;
}

/// How much later than the median the controller reads casd's packets from the line.
std::optional<double> reading_spread_us(const std::vector<PathAccount>& paths) {
  for (const PathAccount& path : paths) {
    for (const HopFigures& hop : path.hops) {
      const bool is_reading = hop.from == HopPoint::kCasdOut && hop.to == HopPoint::kController;
      if (path.message == "HIL_SENSOR" && is_reading && hop.delay.count > 0) {
        return hop.delay.p99 - hop.delay.p50;
      }
    }
  }
  return std::nullopt;
}

/// Place of the record's vehicle among the scenario's.
std::size_t vehicle_number(const Scenario& scenario, const RunRecord& record) {
  const VehicleNames names = scenario.names();
  return static_cast<std::size_t>(std::ranges::find(names, record.vehicle) - names.begin());
}

/// Rate of HIL_SENSOR by its stamps.
double stamped_hz(const std::vector<base::LedgerEntry>& ledger, StreamWindow window) {
  std::uint64_t count = 0;
  std::uint64_t first = 0;
  std::uint64_t last = 0;
  for (const base::LedgerEntry& entry : ledger) {
    if (entry.direction != base::LedgerEntry::Direction::kSent) continue;
    if (entry.message_id != HilSensor::kId || !window.holds(entry.time_usec)) continue;
    if (count++ == 0) first = entry.time_usec;
    last = entry.time_usec;
  }
  return last > first ? 1e6 * static_cast<double>(count - 1) / static_cast<double>(last - first)
                      : 0;
}

/// The stream of stock firmware between the simulator and casd's serial port, as that of a real
/// controller. Firmware in software has none: it waits for each packet.
void measure_firmware_stream(const RunRecord& record, Measurement& figures) {
  constexpr double kControls_hz = 200;  // HIL_ACTUATOR_CONTROLS, as PX4 streams it in HIL mode
  const auto window = machine_window(record, figures.incidents);
  const double hz = window ? stamped_hz(record.simulator, *window) : 0;
  figures.streamed = hz > 0;
  if (!figures.streamed) {
    figures.pace.real_time_factor = record.firmware->real_time_factor;
    return;
  }
  figures.window = *window;
  measure_stream({.sensor_hz = hz, .controls_hz = kControls_hz}, record, figures);
  if (record.relay) figures.port_gap_ms = longest_gap_ms(record, HilSensor::kId, *window);
}

/// What only stock firmware has.
void measure_firmware(const Scenario& scenario, const RunRecord& record,
                      std::span<const PoseSample> truth, Measurement& figures) {
  figures.firmware = record.firmware;
  if (figures.firmware->fence) add_reach(truth, *figures.firmware->fence);
  if (scenario.fence) figures.fence = kept_by(record.firmware->version, *scenario.fence);
  figures.not_flown = steps_not_flown(record.stages, truth);
  std::ranges::copy(record.firmware->not_its_own, std::back_inserter(figures.not_flown));
}

}  // namespace

void measure_stream(const Rates& nominal, const RunRecord& record, Measurement& figures) {
  const std::uint32_t controls_id = controls_message_id(record);
  const auto& [simulator, controller] = std::tie(record.simulator, record.controller);
  const StreamWindow window = figures.window;
  figures.rates.sensor = account(simulator, controller, HilSensor::kId, window, nominal.sensor_hz);
  figures.rates.gps = account(simulator, controller, HilGps::kId, window, nominal.gps_hz);
  figures.rates.controls = account(controller, simulator, controls_id, window, nominal.controls_hz);
  if (!record.foreign_stamps) measure_echoes(simulator, controller, controls_id, figures);
  figures.sensor_uplink = summarise(hop_delays_ns(simulator, controller, HilSensor::kId, window));
  figures.controls_downlink = summarise(hop_delays_ns(controller, simulator, controls_id, window));
  figures.meter = {.sensor_hz = meter_hz(controller, HilSensor::kId, window),
                   .gps_hz = meter_hz(controller, HilGps::kId, window),
                   .controls_hz = meter_hz(simulator, controls_id, window)};
  const RelayLedgers* relay = record.relay ? &*record.relay : nullptr;
  for (const PacketPath& path :
       {PacketPath{"HIL_SENSOR", HilSensor::kId, true}, PacketPath{"HIL_GPS", HilGps::kId, true},
        PacketPath{"controls", controls_id, false}}) {
    figures.paths.push_back(
        account_path(path, simulator, controller, record.from_device ? nullptr : relay, window));
  }
  figures.pace = pace(simulator, HilSensor::kId, window);
  // With one blocking thread casd reads only after the line has taken the previous bytes: this
  // delay belongs to the architecture, not to the machine.
  if (figures.architecture == Architecture::kTs) return;
  figures.handover_p99_us = handover_p99_us(figures.paths);
  figures.reading_spread_us = reading_spread_us(figures.paths);
  figures.paused_ms = paused_ms(figures.paths);
}

std::optional<double> longest_gap_ms(const RunRecord& record, std::uint32_t message_id,
                                     StreamWindow window) {
  std::optional<std::int64_t> before_ns;
  std::optional<std::int64_t> longest_ns;
  for (const base::LedgerEntry& entry : record.controller) {
    if (entry.direction != base::LedgerEntry::Direction::kReceived ||
        entry.message_id != message_id || !window.holds(entry.time_usec)) {
      continue;
    }
    if (before_ns) longest_ns = std::max(longest_ns.value_or(0), entry.at_ns - *before_ns);
    before_ns = entry.at_ns;
  }
  if (!longest_ns) return std::nullopt;
  return 1e-6 * static_cast<double>(*longest_ns);
}

Measurement measure(const RunRequest& request, const RunRecord& record) {
  const Scenario& scenario = request.scenario;
  Measurement figures;
  figures.scenario = scenario.name;
  figures.vehicle = record.vehicle;
  figures.architecture = request.architecture;
  figures.seed = request.seed;
  figures.virtual_clock = record.virtual_clock;
  figures.lockstep = record.lockstep;
  figures.flight_failure = record.flight_failure;
  figures.simulated_s = record.simulated_s;
  figures.wall_s = record.wall_s;
  figures.cpu_s = record.cpu_s;
  figures.cpu_pressure = record.cpu_pressure;
  figures.from_device = record.from_device;
  figures.lost_by_sequence = record.lost_by_sequence;
  figures.stages = record.stages;
  figures.under_way = record.under_way;
  figures.faults = record.faults;
  figures.never_began = faults_that_never_began(scenario.faults, vehicle_number(scenario, record),
                                                record.faults, record.flown_stages());
  figures.changes = flight_changes(record, casd::GainMap::shipped(), scenario.ground_station);
  figures.warnings = record.warnings;
  figures.plugins = read_plugin_figures(record.plugin_figures, record.vehicle);
  const bool is_recorded = !record.firmware || std::filesystem::exists(record.truth_csv);
  const std::vector<PoseSample> none;
  const std::vector<PoseSample>& truth = is_recorded ? record.truth() : none;
  figures.responses = step_responses(record.stages, truth);
  figures.truth_samples = truth.size();
  figures.record_hole = record_hole(record.flown_stages(), truth);
  figures.transition_height_m = transition_height_m(record.stages, truth);
  figures.landing_error_m = landing_error_m(record.stages, truth);
  figures.beacon_error_m = beacon_error_m(figures.plugins);
  figures.sticks_way_m = sticks_way_m(record.stages, truth);
  figures.incidents = find_incidents(record.flown_stages(), truth);
  const std::filesystem::path simulator_config =
      RunPaths::of(scenario, request.out, request.out).simulator_config();
  name_struck_objects(simulator_config, truth, figures.incidents);
  figures.clearance = terrain_clearance(record.stages, truth, simulator_config);
  figures.strike = read_strike_response(record, scenario.steps, scenario.faults.vehicle, truth);
  figures.over_hold = record.hold.has_value();
  figures.window = record.hold ? window_of(*record.hold) : whole_stream(record);
  if (record.firmware) {
    measure_firmware(scenario, record, truth, figures);
    measure_firmware_stream(record, figures);
  } else {
    measure_stream(scenario.rates, record, figures);
  }
  if (record.virtual_clock && record.wall_s > 0) {
    figures.pace.real_time_factor = record.simulated_s / record.wall_s;
  }
  if (record.hold) measure_motion(record, truth, figures);
  return figures;
}

std::vector<FaultThatNeverBegan> faults_that_never_began(
    const ScenarioFaults& faults, std::size_t vehicle,
    const std::vector<BenchFaultScript::Span>& begun, const std::vector<Stage>& stages) {
  std::vector<FaultThatNeverBegan> never;
  for (const BenchFault& fault : faults.bench) {
    if (!fault.is_everybodys() && fault.vehicle != vehicle) continue;
    never.push_back({.name = fault.name, .by_time = fault.at.has_value()});
  }
  std::size_t number = 0;  // as the vehicle's plugin counts them
  for (const VehicleFault& fault : faults.vehicle) {
    if (fault.vehicle.value_or(vehicle) != vehicle) continue;
    never.push_back({.name = sim::parse_fault(fault.script, ++number).name,
                     .by_time = fault.script.has("at_s")});
  }
  for (const BenchFaultScript::Span& span : begun) {
    const bool after = !stages.empty() && span.begin > stages.back().end;
    const auto found = std::ranges::find_if(never, [&](const FaultThatNeverBegan& fault) {
      return fault.name == span.name && !(after && fault.by_time);
    });
    if (found != never.end()) never.erase(found);
  }
  return never;
}

}  // namespace cas::hils
