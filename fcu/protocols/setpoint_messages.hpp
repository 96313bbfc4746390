// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "base/time/clock.hpp"
#include "mavlink/common/hil_rc_inputs_raw.hpp"
#include "mavlink/common/manual_control.hpp"
#include "mavlink/common/rc_channels_override.hpp"
#include "mavlink/common/set_attitude_target.hpp"
#include "mavlink/common/set_position_target_global_int.hpp"
#include "mavlink/common/set_position_target_local_ned.hpp"

namespace cas::fcu {

struct FcuCore;

// What companions and pilots stream.

/// Frames LOCAL_NED, LOCAL_OFFSET_NED (about the present place), BODY_NED and BODY_FRD (turned by
/// the present heading).
void on_position_target(const mavlink::common::SetPositionTargetLocalNed& m, FcuCore& core,
                        base::RunTime now);
void on_global_target(const mavlink::common::SetPositionTargetGlobalInt& m, FcuCore& core,
                      base::RunTime now);
/// Attitude with thrust 0..1 of full scale.
void on_attitude_target(const mavlink::common::SetAttitudeTarget& m, FcuCore& core,
                        base::RunTime now);
/// x forward, y right, r clockwise -1000..1000, z thrust 0..1000.
void on_manual_control(const mavlink::common::ManualControl& m, FcuCore& core, base::RunTime now);
/// Channels 1 roll, 2 pitch (low is nose down), 3 throttle, 4 yaw: 1000..2000 us.
void on_rc_inputs(const mavlink::common::HilRcInputsRaw& m, FcuCore& core, base::RunTime now);
void on_rc_override(const mavlink::common::RcChannelsOverride& m, FcuCore& core, base::RunTime now);

}  // namespace cas::fcu
