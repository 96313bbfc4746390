// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "base/config/vehicle.hpp"
#include "hils/scenario/scenario.hpp"

namespace cas::hils {

/// State of a flight controller on a serial port before its flight.
struct FcuFacts {
  std::string device{};
  std::optional<std::uint8_t> system{};  ///< that it must have; nullopt: any
  bool link_up = false;
  std::string link_words{};  ///< where it is, or why it is not up
  bool heard = false;        ///< its HEARTBEAT has come
  std::string elsewhere{};   ///< casd's link that it came by, where that is not this vehicle's
  bool hil = false;          ///< and says that it flies a simulation
  bool armed = false;
  std::string autopilot{};           ///< "px4", "ardupilot", "generic"
  std::optional<double> sys_hitl{};  ///< PX4's parameter
  double sensor_hz = 0;              ///< HIL_SENSOR written to the port
  double controls_hz = 0;            ///< controls that come from it
  double crc_errors = 0;             ///< damaged packets from it
  bool by_rotor = true;              ///< controls are for rotors (HIL_ACTUATOR_CONTROLS), not axes
};

/// One thing that was looked at.
struct FcuFinding {
  bool good = true;
  bool fatal = false;  ///< the flight would be worthless or not allowed
  std::string what;
  std::string remedy{};  ///< advice
};

/// Judges a controller before the flight of `vehicle`. Pure.
std::vector<FcuFinding> check_fcu(const FcuFacts& facts, const Rates& nominal,
                                  const base::Vehicle& vehicle);

/// For the terminal, one line each; the remedies are steps of docs/use/pixhawk.md.
std::string findings_text(const std::vector<FcuFinding>& findings);
bool may_fly(const std::vector<FcuFinding>& findings);

}  // namespace cas::hils
