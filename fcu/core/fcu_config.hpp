// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "base/config/config.hpp"
#include "base/config/vehicle.hpp"
#include "base/earth/geodesy.hpp"
#include "base/earth/magnetic_field.hpp"
#include "fcu/line/line_model.hpp"

namespace cas::fcu {

/// Which time the estimator takes a sensor message to have: its own stamp, or its arrival (as PX4
/// does in HITL).
enum class StampMode { kMessage, kArrival };

/// Clock of timers, telemetry and failsafes of fcu_emulator.
enum class Pace {
  kRealtime,  ///< the steady clock
  kLockstep,  ///< the stream of HIL_SENSOR
};

/// The message that carries the answer.
enum class ActuatorMessage {
  kAuto,                ///< HIL_CONTROLS for the four rotors of [HILS] Eq. (3), else the other
  kHilControls,         ///< U1..U4: the simulator finds the rotors' speeds
  kHilActuatorControls  ///< outputs of up to 16 motors and servos
};

/// An emulated flight controller as config/fcu/*.yaml describes it.
struct FcuConfig {
  base::Vehicle vehicle;
  /// The sensors' data sheets by plugin name: those of the vehicle file, or a set named instead.
  base::ConfigNode sensors = base::ConfigNode::empty();
  std::uint8_t system_id = 1;
  std::uint8_t component_id = 1;
  LineConfig line;
  Pace pace = Pace::kRealtime;
  StampMode stamp = StampMode::kMessage;
  ActuatorMessage actuators = ActuatorMessage::kAuto;
  double control_rate_hz = 400;
  double decimal_year = base::kUsualYear;  ///< for the magnetic field model
  /// Origin of the local frame. nullopt: the first position fixes, averaged at rest.
  std::optional<base::Geodetic> home_hint;
  std::uint64_t seed = 1;                              ///< of the line model
  std::vector<std::pair<std::string, double>> params;  ///< values that differ from the defaults

  /// @throws base::ConfigError
  static FcuConfig load(const std::filesystem::path& file);
  static FcuConfig parse(const base::ConfigNode& node);
};

/// Every key of FcuConfig with its default and meaning, and those of its line, as tables in
/// Markdown: for `fcu_emulator --keys` and docs/reference/config.md.
std::string controller_reference();

}  // namespace cas::fcu
