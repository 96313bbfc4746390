// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "base/time/clock.hpp"

namespace cas::fcu {

struct FcuCore;

// How the vehicle and its parts are. Each sends one message now, in the MAVLink version given.

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

}  // namespace cas::fcu
