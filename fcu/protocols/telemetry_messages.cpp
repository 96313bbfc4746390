// SPDX-License-Identifier: BSD-3-Clause
#include "fcu/protocols/telemetry_messages.hpp"

#include "fcu/protocols/telemetry_health.hpp"
#include "fcu/protocols/telemetry_motion.hpp"
#include "fcu/protocols/version_info.hpp"
#include "mavlink/common/altitude.hpp"
#include "mavlink/common/attitude.hpp"
#include "mavlink/common/attitude_quaternion.hpp"
#include "mavlink/common/attitude_target.hpp"
#include "mavlink/common/autopilot_version.hpp"
#include "mavlink/common/available_modes.hpp"
#include "mavlink/common/battery_status.hpp"
#include "mavlink/common/current_mode.hpp"
#include "mavlink/common/estimator_status.hpp"
#include "mavlink/common/extended_sys_state.hpp"
#include "mavlink/common/global_position_int.hpp"
#include "mavlink/common/gps_global_origin.hpp"
#include "mavlink/common/gps_raw_int.hpp"
#include "mavlink/common/heartbeat.hpp"
#include "mavlink/common/home_position.hpp"
#include "mavlink/common/local_position_ned.hpp"
#include "mavlink/common/mission_current.hpp"
#include "mavlink/common/position_target_local_ned.hpp"
#include "mavlink/common/protocol_version.hpp"
#include "mavlink/common/scaled_pressure.hpp"
#include "mavlink/common/servo_output_raw.hpp"
#include "mavlink/common/sys_status.hpp"
#include "mavlink/common/system_time.hpp"
#include "mavlink/common/vfr_hud.hpp"
#include "mavlink/common/vibration.hpp"

namespace cas::fcu {

using namespace mavlink::common;  // NOLINT: the file is about its messages

namespace {

constexpr MessageSource kSources[] = {
    {Heartbeat::kId, 1, send_heartbeat},
    {SysStatus::kId, 1, send_sys_status},
    {Attitude::kId, 50, send_attitude},
    {AttitudeQuaternion::kId, 10, send_attitude_quaternion},
    {AttitudeTarget::kId, 2, send_attitude_target},
    {LocalPositionNed::kId, 30, send_local_position},
    {PositionTargetLocalNed::kId, 10, send_position_target},
    {GlobalPositionInt::kId, 5, send_global_position},
    {GpsRawInt::kId, 2, send_gps_raw},
    {VfrHud::kId, 4, send_vfr_hud},
    {mavlink::common::Altitude::kId, 1, send_altitude},
    {Vibration::kId, 0.5, send_vibration},
    {EstimatorStatus::kId, 1, send_estimator_status},
    {ExtendedSysState::kId, 1, send_extended_sys_state},
    {BatteryStatus::kId, 0.5, send_battery_status},
    {HomePosition::kId, 0.5, send_home_position},
    {GpsGlobalOrigin::kId, 0, send_gps_global_origin},
    {ServoOutputRaw::kId, 2, send_servo_output_raw},
    {ScaledPressure::kId, 0, send_scaled_pressure},
    {SystemTime::kId, 1, send_system_time},
    {MissionCurrent::kId, 1, send_mission_current},
    {AutopilotVersion::kId, 0, send_autopilot_version},
    {ProtocolVersion::kId, 0, send_protocol_version},
    {AvailableModes::kId, 0, send_available_modes},
    {CurrentMode::kId, 0.5, send_current_mode},
};

}  // namespace

std::span<const MessageSource> message_sources() { return kSources; }

}  // namespace cas::fcu
