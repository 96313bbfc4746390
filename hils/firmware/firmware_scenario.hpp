// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "base/config/config.hpp"
#include "base/time/clock.hpp"
#include "hils/flight/bench_fault.hpp"
#include "hils/flight/flight_step.hpp"
#include "hils/scenario/scenario.hpp"

namespace cas::hils {

/// A stock flight controller that is started as a program of this machine. In each text ${NAME} is
/// a variable of the environment, with which the user says where the firmware is.
struct Firmware {
  std::vector<std::string> command;  ///< argv, the program first
  /// PX4's start script, behind the command as `-s FILE`: without one v1.12 runs the board's own
  /// script, which mounts and formats, and ends with 255. Empty: none.
  std::string start;
  std::string least_version;  ///< "1.12": oldest version that is flown; empty: any
  std::string hint;           ///< remedy if it ends before its first HEARTBEAT
  std::string cwd;            ///< where it runs; empty: a folder in the results
  std::map<std::string, std::string> environment;
  int instances = 1;  ///< of the program: one for each of the world's first vehicles
  bool on_serial_line =
      false;  ///< ${CAS_FCU_TTY} is the end of a pseudo-terminal, casd has the other
  base::ConfigNode node = base::ConfigNode::empty("firmware");  ///< for errors on its keys
};

/// Most programs of one run, as most vehicles of a scenario of our controller.
inline constexpr int kMostInstances = 16;

/// The system id of the vehicle that an instance flies, from 1: PX4 in software takes this one by
/// itself.
constexpr std::uint8_t system_of_instance(std::size_t instance) {
  return static_cast<std::uint8_t>(instance + 1);
}

/// Whether it is no version, but what a build says of a tree that was cloned without tags: PX4
/// 1.8.0, others 0.0.0.
bool is_of_a_tree_without_tags(const std::string& version);
/// Whether a version is a later one or the same: "1.16.1" is at least "1.12".
bool is_at_least(const std::string& version, const std::string& least);

/// A flight of stock firmware: a shipped world and topology, as one would start them by hand, the
/// firmware, and the steps of a flight.
struct FirmwareScenario {
  std::string name;
  std::string description;
  std::filesystem::path file{};
  std::filesystem::path world;
  VehicleNames vehicles = only_vehicle();  ///< the world's first, which are flown
  std::string autopilot;                   ///< autopilot_of_plugin() of its first vehicle
  std::filesystem::path topology;
  Firmware firmware;
  bool not_hil = false;                     ///< arm although it does not say that it is in HIL
  std::optional<base::ConfigNode> sensors;  ///< in the place of those of the flown vehicles
  std::vector<base::ConfigNode> plugins;    ///< of the flown vehicles, behind their own
  ScenarioFaults faults;
  std::vector<FlightStep> steps;
  std::optional<Geofence> fence;  ///< of the autopilots, for this flight
  /// Motion in the measured step, as FirmwareFigures has it: a hold is judged about its mean, the
  /// estimate against the truth.
  Limits limits;
  std::optional<double> height_error_m;    ///< most of the true height's mean in measured holds
  std::optional<double> drift_m;           ///< farthest from where the hold began, true, horizontal
  std::optional<double> hop_p99_us;        ///< most of any way through casd
  std::map<std::string, double> rates_hz;  ///< least of the vehicle's messages in the hold

  std::vector<double> start_yaw_rad{};  ///< of the flown vehicles, from north, in the world file

  /// Whether it has steps that hils flies on a link of its own: trajectories, missions, breaches.
  bool needs_companion() const;
  bool flies_several() const { return vehicles.size() > 1; }
  /// Suffix of the names of a vehicle's files and program: "_iris1"; empty for a single vehicle.
  std::string suffix_of(std::size_t vehicle) const {
    return flies_several() ? "_" + vehicles[vehicle] : "";
  }

  /// Whether a scenario file is one of these: it has the key `firmware`.
  static bool is(const std::filesystem::path& file);
  /// @throws base::ConfigError with file, line and key path
  static FirmwareScenario load(const std::filesystem::path& file);
};

/// Puts the environment's variables in for ${NAME} and ${NAME:-fallback}. `more` goes before the
/// environment.
/// @throws base::ConfigError that names the missing variable
std::string with_variables(const std::string& text, const std::map<std::string, std::string>& more);

/// Name of casd's link for hils's own packets to a vehicle.
std::string companion_link_name(std::size_t vehicle);

/// Where the pieces of a flight of stock firmware are.
struct FirmwarePlaces {
  std::filesystem::path out;             ///< results: truth.csv, flight.tlog, summary.json
  std::filesystem::path run;             ///< effective configurations, figures, program output
  std::filesystem::path sockets;         ///< short-lived: control sockets, ends of the serial line
  std::filesystem::path command_port{};  ///< casd's Unix socket
  std::vector<std::uint16_t> companions{};  ///< UDP ports of hils, for a link of casd each

  std::filesystem::path simulator_config() const { return run / "hilsim.yaml"; }
  std::filesystem::path casd_config() const { return run / "casd.yaml"; }
  std::filesystem::path simulator_ledger() const { return run / "simulator_ledger.csv"; }
  std::filesystem::path casd_ledger() const { return run / "casd_ledger.csv"; }
  std::filesystem::path simulator_stats() const { return run / "hilsim_stats.json"; }
  /// @param suffix  FirmwareScenario::suffix_of()
  std::filesystem::path truth_csv(const std::string& suffix = {}) const {
    return out / ("truth" + suffix + ".csv");
  }
  std::filesystem::path flight_tlog() const { return out / "flight.tlog"; }
  std::filesystem::path simulator_control() const { return sockets / "hilsim"; }
  std::filesystem::path command_token() const { return sockets / "casd.token"; }
  std::filesystem::path casd_tty() const { return sockets / "casd_tty"; }
  std::filesystem::path firmware_tty() const { return sockets / "firmware_tty"; }
};

/// Writes the scenario's world and topology as the programs are given them: with a recorder,
/// control sockets in the run's folder and casd's serial link at the firmware's line. @throws
/// base::ConfigError
void write_firmware_configs(const FirmwareScenario& scenario, const FirmwarePlaces& places);

}  // namespace cas::hils
