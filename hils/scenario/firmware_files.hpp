// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "hils/scenario/scenario.hpp"

namespace cas::hils {

/// The simulation and the topology that stock firmware wants for the vehicles, place and world of
/// a scenario: what a user would otherwise write as two files by hand. Instance N of PX4 connects
/// to TCP port 4560 + N, one of ArduPilot sends to UDP port 9002 + 10 N, both talk to casd at
/// UDP port 14550; other ground stations join at 14551. On a serial line it is a board on USB.
/// @param firmware  with its autopilot, `on_serial_line` and `not_hil`
base::ConfigNode firmware_world(const Scenario& scenario, const Firmware& firmware);
base::ConfigNode firmware_topology(const Scenario& scenario, const Firmware& firmware);

}  // namespace cas::hils
