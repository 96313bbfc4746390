// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/config/config.hpp"

namespace cas::hils {

struct Scenario;

/// A stock flight controller that is started as a program of this machine, and the simulation and
/// topology in which one would start it by hand: files, or made for the vehicles that the scenario
/// names (firmware_files.hpp). In each text ${NAME} is a variable of the
/// environment, with which the user says where the firmware is.
struct Firmware {
  std::vector<std::string> command;  ///< argv, the program first
  /// PX4's start script, behind the command as `-s FILE`: without one v1.12 runs the board's own
  /// script, which mounts and formats, and ends with 255. Empty: none.
  std::string start;
  std::string least_version;  ///< "1.12": oldest version that is flown; empty: any
  std::string hint;           ///< remedy if it ends before its first HEARTBEAT
  std::string cwd;            ///< where it runs; empty: a folder in the results
  std::map<std::string, std::string> environment;
  bool on_serial_line = false;  ///< ${CAS_FCU_TTY} is the end of a pseudo-terminal, casd has the
                                ///< other: HITL, in real time
  base::ConfigNode world = base::ConfigNode::empty("world");
  base::ConfigNode topology = base::ConfigNode::empty("topology");
  std::string autopilot;       ///< "PX4", "ArduPilot": autopilot_of_plugin() of the first vehicle
  bool external_ahrs = false;  ///< its sensors come by plugin external_ahrs, on ${CAS_AHRS_TTY}
  /// The user's word that nothing is connected to the outputs of an autopilot without a HIL mode.
  bool outputs_disconnected = false;
  /// Tells PX4 where its local frame begins: it has no satellites to know its home by.
  bool tells_origin = false;
  bool not_hil = false;                     ///< arm although it does not say that it is in HIL
  std::optional<base::ConfigNode> sensors;  ///< in the place of those of the flown vehicles
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

/// The autopilot that a world's plugin serves: "PX4", "ArduPilot"; empty: none. A vehicle with
/// several has the first of them that serves one; external_ahrs goes before mavlink_interface.
std::string_view autopilot_of_plugin(std::string_view plugin);

/// Puts the environment's variables in for ${NAME} and ${NAME:-fallback}. `more` goes before the
/// environment.
/// @throws base::ConfigError that names the missing variable
std::string with_variables(const std::string& text, const std::map<std::string, std::string>& more);

/// Reads the keys of a scenario that stock firmware flies, but for those of every scenario
/// (Scenario::load): `firmware`, its `world` with the vehicles unless the scenario has named them,
/// `topology`, `geofence`, `sensors`.
/// @throws base::ConfigError with file, line and key path
void read_firmware(const base::ConfigNode& root, Scenario& scenario);

}  // namespace cas::hils
