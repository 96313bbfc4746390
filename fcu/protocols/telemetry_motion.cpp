// SPDX-License-Identifier: BSD-3-Clause
#include "fcu/protocols/telemetry_motion.hpp"

#include <algorithm>
#include <cmath>

#include "base/earth/frames.hpp"
#include "fcu/core/fcu_core.hpp"
#include "fcu/protocols/wire_units.hpp"
#include "mavlink/common/altitude.hpp"
#include "mavlink/common/attitude.hpp"
#include "mavlink/common/attitude_quaternion.hpp"
#include "mavlink/common/attitude_target.hpp"
#include "mavlink/common/global_position_int.hpp"
#include "mavlink/common/gps_global_origin.hpp"
#include "mavlink/common/home_position.hpp"
#include "mavlink/common/local_position_ned.hpp"
#include "mavlink/common/position_target_local_ned.hpp"
#include "mavlink/common/vfr_hud.hpp"

namespace cas::fcu {

using base::RunTime;
using Eigen::Vector3d;
using namespace mavlink::common;  // NOLINT: the file is about its messages

namespace {

double amsl(const FcuCore& core, double z) {
  return (core.estimator.projection() ? core.estimator.projection()->home().alt_m : 0.0) - z;
}

}  // namespace

void send_attitude(FcuCore& core, RunTime now, int version) {
  const EstimatorState& s = core.estimator.state();
  const Vector3d rpy = base::euler_rpy(s.q_ND);
  core.outbox.reply(
      Attitude{core.time_boot_ms(now), to_float(rpy.x()), to_float(rpy.y()), to_float(rpy.z()),
               to_float(s.w_D.x()), to_float(s.w_D.y()), to_float(s.w_D.z())},
      version);
}

void send_attitude_quaternion(FcuCore& core, RunTime now, int version) {
  const EstimatorState& s = core.estimator.state();
  AttitudeQuaternion m;
  m.time_boot_ms = core.time_boot_ms(now);
  m.q1 = to_float(s.q_ND.w());
  m.q2 = to_float(s.q_ND.x());
  m.q3 = to_float(s.q_ND.y());
  m.q4 = to_float(s.q_ND.z());
  m.rollspeed = to_float(s.w_D.x());
  m.pitchspeed = to_float(s.w_D.y());
  m.yawspeed = to_float(s.w_D.z());
  core.outbox.reply(m, version);
}

void send_attitude_target(FcuCore& core, RunTime now, int version) {
  if (!core.commander.flying()) return;
  const AttitudeSetpoint& s = core.cascade.attitude_setpoint();
  const Vector3d& w = core.cascade.rate_setpoint();
  AttitudeTarget m;
  m.time_boot_ms = core.time_boot_ms(now);
  m.q = {to_float(s.q_ND.w()), to_float(s.q_ND.x()), to_float(s.q_ND.y()), to_float(s.q_ND.z())};
  m.body_roll_rate = to_float(w.x());
  m.body_pitch_rate = to_float(w.y());
  m.body_yaw_rate = to_float(w.z());
  m.thrust = to_float(s.thrust_n / core.config.vehicle.scales.u1_max_n);
  core.outbox.reply(m, version);
}

void send_local_position(FcuCore& core, RunTime now, int version) {
  if (!core.estimator.projection()) return;
  const EstimatorState& s = core.estimator.state();
  core.outbox.reply(LocalPositionNed{core.time_boot_ms(now), to_float(s.p_N.x()),
                                     to_float(s.p_N.y()), to_float(s.p_N.z()), to_float(s.v_N.x()),
                                     to_float(s.v_N.y()), to_float(s.v_N.z())},
                    version);
}

void send_position_target(FcuCore& core, RunTime now, int version) {
  const ControlSetpoint& setpoint = core.commander.setpoint();
  if (!setpoint.trajectory) return;
  const TrajectorySetpoint& t = *setpoint.trajectory;
  PositionTargetLocalNed m;
  m.time_boot_ms = core.time_boot_ms(now);
  m.coordinate_frame = MavFrame::kLocalNed;
  m.x = to_float(t.p_N.x());
  m.y = to_float(t.p_N.y());
  m.z = to_float(t.p_N.z());
  m.vx = to_float(t.v_N.x());
  m.vy = to_float(t.v_N.y());
  m.vz = to_float(t.v_N.z());
  m.afx = to_float(t.a_N.x());
  m.afy = to_float(t.a_N.y());
  m.afz = to_float(t.a_N.z());
  m.yaw = to_float(t.yaw_rad);
  m.yaw_rate = to_float(t.yaw_rate_rad_s);
  core.outbox.reply(m, version);
}

void send_global_position(FcuCore& core, RunTime now, int version) {
  if (!core.estimator.projection()) return;
  const EstimatorState& s = core.estimator.state();
  const base::Geodetic place = core.estimator.projection()->to_geodetic(s.p_N);
  GlobalPositionInt m;
  m.time_boot_ms = core.time_boot_ms(now);
  m.lat = deg_e7(place.lat_deg);
  m.lon = deg_e7(place.lon_deg);
  m.alt = milli(place.alt_m);
  m.relative_alt = milli(core.home_N.z() - s.p_N.z());
  m.vx = centi(s.v_N.x());
  m.vy = centi(s.v_N.y());
  m.vz = centi(s.v_N.z());
  m.hdg = heading_cdeg(base::euler_rpy(s.q_ND).z());
  core.outbox.reply(m, version);
}

void send_vfr_hud(FcuCore& core, RunTime, int version) {
  const EstimatorState& s = core.estimator.state();
  VfrHud m;
  m.groundspeed = to_float(s.v_N.head<2>().norm());
  m.airspeed = m.groundspeed;
  m.heading = static_cast<std::int16_t>(heading_cdeg(base::euler_rpy(s.q_ND).z()) / 100);
  const double throttle = core.cascade.output().u[0] / core.config.vehicle.scales.u1_max_n;
  m.throttle = static_cast<std::uint16_t>(std::lround(100 * std::clamp(throttle, 0.0, 1.0)));
  m.alt = to_float(amsl(core, s.p_N.z()));
  m.climb = to_float(-s.v_N.z());
  core.outbox.reply(m, version);
}

void send_altitude(FcuCore& core, RunTime now, int version) {
  const EstimatorState& s = core.estimator.state();
  mavlink::common::Altitude m;
  m.time_usec = core.time_boot_us(now);
  m.altitude_amsl = to_float(amsl(core, s.p_N.z()));
  m.altitude_monotonic = to_float(amsl(core, s.p_N.z()) + s.baro_offset_m);
  m.altitude_local = to_float(-s.p_N.z());
  m.altitude_relative = to_float(core.home_N.z() - s.p_N.z());
  m.altitude_terrain = to_float(kUnset);
  m.bottom_clearance = to_float(kUnset);
  core.outbox.reply(m, version);
}

void send_home_position(FcuCore& core, RunTime now, int version) {
  if (!core.home_set || !core.estimator.projection()) return;
  const base::Geodetic place = core.estimator.projection()->to_geodetic(core.home_N);
  const Eigen::Quaterniond q = base::quaternion_rpy(0, 0, core.home_yaw_rad);
  HomePosition m;
  m.latitude = deg_e7(place.lat_deg);
  m.longitude = deg_e7(place.lon_deg);
  m.altitude = milli(place.alt_m);
  m.x = to_float(core.home_N.x());
  m.y = to_float(core.home_N.y());
  m.z = to_float(core.home_N.z());
  m.q = {to_float(q.w()), to_float(q.x()), to_float(q.y()), to_float(q.z())};
  m.approach_x = m.approach_y = m.approach_z = to_float(kUnset);
  m.time_usec = core.time_boot_us(now);
  core.outbox.reply(m, version);
}

void send_gps_global_origin(FcuCore& core, RunTime now, int version) {
  if (!core.estimator.origin_final()) return;
  const base::Geodetic& origin = core.estimator.projection()->home();
  core.outbox.reply(GpsGlobalOrigin{deg_e7(origin.lat_deg), deg_e7(origin.lon_deg),
                                    milli(origin.alt_m), core.time_boot_us(now)},
                    version);
}

}  // namespace cas::fcu
