// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "base/time/clock.hpp"

namespace cas::fcu {

struct FcuCore;

// Each sends one message now, in the given MAVLink version; nothing while its content is unknown.

// Where the vehicle is, and where it is going.
void send_attitude(FcuCore& core, base::RunTime now, int version);
void send_attitude_quaternion(FcuCore& core, base::RunTime now, int version);
void send_attitude_target(FcuCore& core, base::RunTime now, int version);
void send_local_position(FcuCore& core, base::RunTime now, int version);
void send_position_target(FcuCore& core, base::RunTime now, int version);
void send_global_position(FcuCore& core, base::RunTime now, int version);
void send_vfr_hud(FcuCore& core, base::RunTime now, int version);
void send_altitude(FcuCore& core, base::RunTime now, int version);
void send_home_position(FcuCore& core, base::RunTime now, int version);
void send_gps_global_origin(FcuCore& core, base::RunTime now, int version);

// How the vehicle and its parts are.
void send_heartbeat(FcuCore& core, base::RunTime now, int version);
void send_sys_status(FcuCore& core, base::RunTime now, int version);
void send_extended_sys_state(FcuCore& core, base::RunTime now, int version);
void send_battery_status(FcuCore& core, base::RunTime now, int version);
void send_estimator_status(FcuCore& core, base::RunTime now, int version);
void send_vibration(FcuCore& core, base::RunTime now, int version);
void send_gps_raw(FcuCore& core, base::RunTime now, int version);
void send_scaled_pressure(FcuCore& core, base::RunTime now, int version);
void send_servo_output_raw(FcuCore& core, base::RunTime now, int version);
void send_system_time(FcuCore& core, base::RunTime now, int version);
void send_mission_current(FcuCore& core, base::RunTime now, int version);

// Version and modes.
void send_autopilot_version(FcuCore& core, base::RunTime now, int version);
void send_protocol_version(FcuCore& core, base::RunTime now, int version);
/// All modes, one message each.
void send_available_modes(FcuCore& core, base::RunTime now, int version);
void send_current_mode(FcuCore& core, base::RunTime now, int version);

}  // namespace cas::fcu
