// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "base/measure/ledger.hpp"
#include "hils/flight/bench_fault.hpp"
#include "hils/flight/flight_plan.hpp"
#include "hils/measure/firmware_record.hpp"
#include "hils/measure/flight_changes.hpp"
#include "hils/measure/packet_account.hpp"
#include "hils/measure/tracking.hpp"
#include "hils/run/run_paths.hpp"

namespace cas::hils {

/// Ledgers, files and stages of one vehicle of a finished run, in any architecture.
struct RunRecord {
  std::string vehicle;                        ///< its name
  std::uint8_t system = 1;                    ///< its MAVLink system
  std::vector<base::LedgerEntry> simulator;   ///< HIL packets at the simulator's end
  std::vector<base::LedgerEntry> controller;  ///< HIL packets at the controller's end
  std::optional<RelayLedgers> relay;          ///< at casd's two links, where it kept them
  bool from_device = false;  ///< the controller's end is casd's port: a real one keeps no ledger
  std::uint64_t lost_by_sequence = 0;  ///< then: gaps in the sequence from the controller
  bool foreign_stamps = false;  ///< controls are stamped by another clock: nothing is an echo
  std::filesystem::path truth_csv;
  std::filesystem::path clouds_csv;  ///< returns of its lidars; there is none without a lidar
  std::filesystem::path sensors;     ///< folder with a CSV file of each sensor
  std::filesystem::path flight_tlog;
  std::filesystem::path plugin_figures;  ///< figures of plugins; the file may be missing
  std::vector<Stage> stages;
  std::optional<Stage> under_way;  ///< the step that was not done when the flight ended
  std::optional<Stage> hold;       ///< the measured one; nullopt when the flight did not get there
  std::vector<BenchFaultScript::Span> faults;  ///< of the bench, as they went
  std::vector<std::string> warnings;           ///< of the simulator, about world and vehicle
  std::vector<OutsideCall> outside_calls;      ///< of casd's command port, by others than hils
  ClockMap log_clock;                          ///< clock of the flight log -> simulated time
  std::optional<std::string> flight_failure;   ///< a sentence; nullopt when every step was done
  bool virtual_clock = false;                  ///< time was computed, not waited for
  bool lockstep = false;                       ///< ... by the programs, one waiting for the other
  double simulated_s = 0;                      ///< length of the whole run
  double wall_s = 0;
  std::vector<std::pair<std::string, double>> cpu_s;  ///< processor time by program
  std::optional<double> cpu_pressure;      ///< share of the hold in which some task had to wait
  std::optional<FirmwareRecord> firmware;  ///< of stock firmware

  /// With the one under way.
  std::vector<Stage> flown_stages() const;

  /// Truth of the whole run, read once. @throws base::ConfigError as read_truth does
  const std::vector<PoseSample>& truth() const;
  /// The controller's estimate in the whole run, read once.
  /// @throws base::ConfigError as read_estimate does
  const std::vector<PoseSample>& estimate() const;

  /// Caches of truth() and estimate(); copies of a record share them.
  mutable std::shared_ptr<const std::vector<PoseSample>> truth_read{};
  mutable std::shared_ptr<const std::vector<PoseSample>> estimate_read{};
};

/// A record for each vehicle of a scenario, with its names and where its files are.
std::vector<RunRecord> records_of(const Scenario& scenario, const RunPaths& paths);

/// Adds the faults that the vehicle's plugin `fault` played to those of the bench, and the
/// simulator's warnings.
void add_simulator_report(const RunPaths& paths, RunRecord& record);

/// Faults of one vehicle, as its plugin `fault` reports them in hilsim_stats.json; empty when there
/// is no such file or plugin.
std::vector<BenchFaultScript::Span> vehicle_faults(const std::filesystem::path& simulator_stats,
                                                   const std::string& vehicle);

/// What the simulator did otherwise than the files of the world and of one vehicle say, and the
/// `warnings` of its plugins, from hilsim_stats.json.
std::vector<std::string> simulator_warnings(const std::filesystem::path& simulator_stats,
                                            const std::string& vehicle);

/// HIL_ACTUATOR_CONTROLS where the controller answered with it, else HIL_CONTROLS.
std::uint32_t controls_message_id(const RunRecord& record);

}  // namespace cas::hils
