// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "hils/flight/bench_fault.hpp"
#include "hils/flight/flight_plan.hpp"
#include "hils/measure/flight_changes.hpp"
#include "hils/measure/incident.hpp"
#include "hils/measure/packet_account.hpp"
#include "hils/measure/plugin_figure.hpp"
#include "hils/measure/run_record.hpp"
#include "hils/measure/step_response.hpp"
#include "hils/measure/strike_response.hpp"
#include "hils/measure/terrain_clearance.hpp"
#include "hils/measure/tracking.hpp"
#include "hils/run/run_request.hpp"

namespace cas::hils {

/// A fault of the scenario that did not begin in the whole run.
struct FaultThatNeverBegan {
  std::string name;
  bool by_time = false;  ///< it has a time, not a condition
};

/// Faults that a scenario has for one vehicle less those that began. Faults of the same name are
/// counted. One with a time did not begin in the flight when it came after the last step: programs
/// run on for a while.
///
/// @param stages  the flight as it went
std::vector<FaultThatNeverBegan> faults_that_never_began(
    const ScenarioFaults& faults, std::size_t vehicle,
    const std::vector<BenchFaultScript::Span>& begun, const std::vector<Stage>& stages);

/// The three HIL messages of a run.
struct StreamFigures {
  RateFigures sensor;
  RateFigures gps;
  RateFigures controls;
};

/// Readings of QGroundControl's averaging meter at the end of the window, Hz.
struct MeterReadings {
  double sensor_hz = 0;
  double gps_hz = 0;
  double controls_hz = 0;
};

/// The figures of one vehicle of a run.
struct Measurement {
  std::string scenario;
  std::string vehicle;  ///< its name
  Architecture architecture = Architecture::kTcas;
  std::uint64_t seed = 0;
  bool virtual_clock = false;
  bool lockstep = false;
  bool from_device = false;            ///< of a real controller: packets are followed to its port
  std::uint64_t lost_by_sequence = 0;  ///< then: gaps in the sequence from the controller
  std::optional<std::string> flight_failure;
  double simulated_s = 0;
  double wall_s = 0;
  std::vector<std::pair<std::string, double>> cpu_s;
  std::vector<Stage> stages;
  std::optional<Stage> under_way;          ///< the step that was not done when the flight ended
  std::size_t truth_samples = 0;           ///< of the whole flight
  std::optional<std::string> record_hole;  ///< see record_hole()

  StreamWindow window;     ///< of rates and delays
  bool over_hold = false;  ///< the window is the measured hold, else all that there was
  StreamFigures rates;
  DelayFigures sensor_to_control;  ///< HIL_SENSOR leaves -> its echo arrives, simulator's ledger
  DelayFigures sensor_uplink;      ///< HIL_SENSOR, simulator to controller
  DelayFigures controls_downlink;  ///< controls, controller to simulator
  DelayFigures age_by_stamp;       ///< of the sample at use: since the simulator made it
  DelayFigures age_by_arrival;     ///< the same, since it came to the controller
  MeterReadings meter;
  std::vector<PathAccount> paths;  ///< hop by hop: sensor, GPS, controls
  PaceFigures pace;
  std::optional<double> handover_p99_us;  ///< slowest hop between two programs of the bench
  std::optional<double> paused_ms;        ///< sum of the pauses of the hop that paused most
  /// p99 less p50 of HIL_SENSOR from casd to the controller's read.
  std::optional<double> reading_spread_us;
  /// A controller that is a program of this machine behind a pseudo-terminal: the longest time
  /// between two HIL_SENSOR at its port.
  std::optional<double> port_gap_ms;
  std::optional<double> cpu_pressure;
  std::vector<BenchFaultScript::Span> faults;  ///< of the bench
  std::vector<FaultThatNeverBegan> never_began;
  std::optional<StrikeResponse> strike;         ///< how the vehicle took the first fault
  std::vector<Incident> incidents;              ///< crashes and their kin, in the order of time
  FlightChanges changes;                        ///< of parameters, and commands from outside
  std::vector<StepResponse> responses;          ///< to the steps of the flight
  std::optional<RmsFigures> rms;                ///< truth against reference during the hold
  std::optional<RmsFigures> rms_estimate;       ///< estimate against reference during the hold
  std::optional<double> peak_error_m;           ///< farthest from the reference during the hold
  std::optional<double> height_error_m;         ///< see height_error_m(); nullopt in a trajectory
  std::optional<double> drift_m;                ///< see drift_m(); nullopt in a trajectory
  std::optional<double> rotor_activity_rad_s2;  ///< see rotor_activity_rad_s2(), during the hold
  std::optional<double> radius_error_pct;       ///< of a circle, see step_figures.hpp
  std::optional<double> least_airspeed_m_s;     ///< in the measured step
  std::optional<double> transition_height_m;    ///< the most that a transition changed the height
  std::optional<double> landing_error_m;        ///< from where `land` was begun
  std::optional<double> beacon_error_m;         ///< from the beacon, at the end
  std::optional<double> sticks_way_m;           ///< flown in `sticks`
  std::optional<TerrainClearance> clearance;    ///< in missions above terrain
  std::vector<std::string> warnings;            ///< of the simulator, a sentence each
  std::optional<FirmwareRecord> firmware;       ///< of stock firmware
  bool streamed =
      true;  ///< the HIL stream was recorded; firmware in software waits for each packet
  std::optional<Geofence> fence;       ///< as the firmware keeps it
  std::vector<std::string> not_flown;  ///< steps reported as done that the truth does not show
  std::vector<PluginFigure> plugins;   ///< reported by the vehicle's plugins
};

/// Works out rates, delays, accounts and pace of the HIL stream in the window of the figures.
void measure_stream(const Rates& nominal, const RunRecord& record, Measurement& figures);
/// Longest time between two arrivals of a message at the controller's end; nullopt: fewer than two.
std::optional<double> longest_gap_ms(const RunRecord& record, std::uint32_t message_id,
                                     StreamWindow window);
/// Works out the figures of a vehicle. @throws base::ConfigError when its files cannot be read
Measurement measure(const RunRequest& request, const RunRecord& record);

}  // namespace cas::hils
