// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "base/time/clock.hpp"

namespace cas::fcu {

struct FcuCore;

// Where the vehicle believes to be, and where it is going. Each sends one message now, in the
// MAVLink version given.

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

}  // namespace cas::fcu
