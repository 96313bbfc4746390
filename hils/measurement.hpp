// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "base/ledger.hpp"
#include "hils/bench_fault.hpp"
#include "hils/clock_map.hpp"
#include "hils/flight_plan.hpp"
#include "hils/hop_account.hpp"
#include "hils/packet_account.hpp"
#include "hils/run_request.hpp"
#include "hils/step_response.hpp"
#include "hils/trajectory.hpp"

namespace cas::hils {

/// What a finished run left behind, whatever its architecture.
struct RunRecord {
  std::vector<base::LedgerEntry> simulator;   ///< HIL packets at the simulator's end
  std::vector<base::LedgerEntry> controller;  ///< HIL packets at the controller's end
  std::optional<RelayLedgers> relay;          ///< at casd's two links, where it kept them
  bool from_device = false;  ///< the controller's end is casd's port: a real one keeps no ledger
  std::uint64_t lost_by_sequence = 0;  ///< then: gaps in the sequence from the controller
  bool foreign_stamps = false;  ///< controls are stamped by another clock: nothing is an echo
  std::filesystem::path truth_csv;
  std::filesystem::path flight_tlog;
  std::vector<Stage> stages;
  std::optional<Stage> hold;  ///< the measured one; nothing when the flight did not get there
  std::vector<BenchFaultScript::Span> faults;  ///< of the bench, as they went
  ClockMap log_clock;                          ///< clock of the flight log -> simulated time
  std::string flight_failure;                  ///< a sentence; empty when every step was done
  bool virtual_clock = false;                  ///< time was computed, not waited for
  double simulated_s = 0;                      ///< length of the whole run
  double wall_s = 0;
  std::vector<std::pair<std::string, double>> cpu_s;  ///< processor time by program
  std::optional<double> cpu_pressure;  ///< share of the hold in which some task had to wait
};

/// The three HIL messages of a run.
struct StreamFigures {
  RateFigures sensor;
  RateFigures gps;
  RateFigures controls;
};

/// What QGroundControl's averaging meter would have shown at the end of the window, Hz.
struct MeterReadings {
  double sensor_hz = 0;
  double gps_hz = 0;
  double controls_hz = 0;
};

/// The figures of one run.
struct Measurement {
  std::string scenario;
  Architecture architecture = Architecture::kTcas;
  std::uint64_t seed = 0;
  bool virtual_clock = false;
  bool from_device = false;            ///< of a real controller: packets are followed to its port
  std::uint64_t lost_by_sequence = 0;  ///< then: gaps in the sequence from the controller
  std::string flight_failure;
  double simulated_s = 0;
  double wall_s = 0;
  std::vector<std::pair<std::string, double>> cpu_s;
  std::vector<Stage> stages;

  StreamWindow window;     ///< of rates and delays
  bool over_hold = false;  ///< the window is the measured hold, else all that there was
  StreamFigures rates;
  DelayFigures sensor_to_control;  ///< HIL_SENSOR leaves -> its echo arrives, simulator's ledger
  DelayFigures sensor_uplink;      ///< HIL_SENSOR, simulator to controller
  DelayFigures controls_downlink;  ///< controls, controller to simulator
  DelayFigures age_by_stamp;       ///< of the sample at use: since the simulator made it
  DelayFigures age_by_arrival;     ///< likewise, since it came to the controller
  MeterReadings meter;
  std::vector<PathAccount> paths;  ///< hop by hop: sensor, GPS, controls
  PaceFigures pace;
  std::optional<double> cpu_pressure;
  std::vector<BenchFaultScript::Span> faults;  ///< of the bench
  std::vector<StepResponse> responses;         ///< to the steps of the flight
  std::optional<RmsFigures> rms;               ///< truth against reference during the hold
  std::optional<RmsFigures> rms_estimate;      ///< estimate against reference during the hold
};

/// HIL_ACTUATOR_CONTROLS where the controller answered with it, else HIL_CONTROLS.
std::uint32_t controls_message_id(const RunRecord& record);

/// Works out the figures of a run. @throws base::ConfigError when its files cannot be read
Measurement measure(const RunRequest& request, const RunRecord& record);

}  // namespace cas::hils
