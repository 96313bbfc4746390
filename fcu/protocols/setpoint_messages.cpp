// SPDX-License-Identifier: BSD-3-Clause
#include "fcu/protocols/setpoint_messages.hpp"

#include <algorithm>
#include <cmath>

#include "base/earth/frames.hpp"
#include "fcu/core/fcu_core.hpp"

namespace cas::fcu {

using base::RunTime;
using Eigen::Vector3d;
using namespace mavlink::common;  // NOLINT: the file is about its messages

namespace {

using Mask = PositionTargetTypemask;

/// Reads the parts that the mask does not ignore.
TrajectorySetpoint from_mask(Mask mask, const Vector3d& p, const Vector3d& v, const Vector3d& a,
                             double yaw, double yaw_rate) {
  constexpr Mask kPosition[] = {Mask::kXIgnore, Mask::kYIgnore, Mask::kZIgnore};
  constexpr Mask kVelocity[] = {Mask::kVxIgnore, Mask::kVyIgnore, Mask::kVzIgnore};
  constexpr Mask kAcceleration[] = {Mask::kAxIgnore, Mask::kAyIgnore, Mask::kAzIgnore};
  TrajectorySetpoint out;
  for (int i = 0; i < 3; ++i) {
    if (!has(mask, kPosition[i])) out.p_N[i] = p[i];
    if (!has(mask, kVelocity[i])) out.v_N[i] = v[i];
    if (!has(mask, kAcceleration[i])) out.a_N[i] = a[i];
  }
  if (!has(mask, Mask::kYawIgnore)) out.yaw_rad = yaw;
  if (!has(mask, Mask::kYawRateIgnore)) out.yaw_rate_rad_s = yaw_rate;
  return out;
}

Vector3d vec(float x, float y, float z) {
  return {static_cast<double>(x), static_cast<double>(y), static_cast<double>(z)};
}

double unit(std::int16_t value) { return std::clamp(value / 1000.0, -1.0, 1.0); }

/// Microseconds of a channel to -1..1; what is not a pulse is the middle.
double channel(std::uint16_t pulse_us) {
  if (pulse_us < 800 || pulse_us > 2200) return 0;
  return std::clamp((pulse_us - 1500.0) / 500.0, -1.0, 1.0);
}

void take_channels(std::uint16_t roll, std::uint16_t pitch, std::uint16_t throttle,
                   std::uint16_t yaw, ManualInput& input, RunTime now) {
  input.sticks.roll = channel(roll);
  input.sticks.pitch = -channel(pitch);
  input.sticks.throttle = 0.5 * (channel(throttle) + 1);
  input.sticks.yaw = channel(yaw);
  input.last = now;
  input.seen = true;
}

}  // namespace

void on_position_target(const SetPositionTargetLocalNed& m, FcuCore& core, RunTime now) {
  TrajectorySetpoint setpoint =
      from_mask(m.type_mask, vec(m.x, m.y, m.z), vec(m.vx, m.vy, m.vz), vec(m.afx, m.afy, m.afz),
                static_cast<double>(m.yaw), static_cast<double>(m.yaw_rate));
  const EstimatorState& state = core.estimator.state();
  const bool body = m.coordinate_frame == MavFrame::kBodyNed ||
                    m.coordinate_frame == MavFrame::kBodyFrd ||
                    m.coordinate_frame == MavFrame::kBodyOffsetNed;
  const bool offset = body || m.coordinate_frame == MavFrame::kLocalOffsetNed;
  if (!offset && m.coordinate_frame != MavFrame::kLocalNed) return;
  if (body) {
    const double yaw = base::euler_rpy(state.q_ND).z();
    const Eigen::Rotation2Dd heading(yaw);
    setpoint.p_N.head<2>() = heading * Eigen::Vector2d(setpoint.p_N.head<2>());
    setpoint.v_N.head<2>() = heading * Eigen::Vector2d(setpoint.v_N.head<2>());
    setpoint.a_N.head<2>() = heading * Eigen::Vector2d(setpoint.a_N.head<2>());
    if (std::isfinite(setpoint.yaw_rad))
      setpoint.yaw_rad = base::wrap_angle(setpoint.yaw_rad + yaw);
  }
  if (offset) setpoint.p_N += state.p_N;
  core.commander.offboard().on_trajectory(setpoint, now);
}

void on_global_target(const SetPositionTargetGlobalInt& m, FcuCore& core, RunTime now) {
  const auto& projection = core.estimator.projection();
  if (!projection) return;
  const Vector3d there =
      projection->to_local({m.lat_int * 1e-7, m.lon_int * 1e-7, projection->home().alt_m});
  const auto alt = static_cast<double>(m.alt);
  const bool relative = m.coordinate_frame == MavFrame::kGlobalRelativeAlt ||
                        m.coordinate_frame == MavFrame::kGlobalRelativeAltInt;
  const double z = relative ? core.home_N.z() - alt : projection->home().alt_m - alt;
  core.commander.offboard().on_trajectory(
      from_mask(m.type_mask, {there.x(), there.y(), z}, vec(m.vx, m.vy, m.vz),
                vec(m.afx, m.afy, m.afz), static_cast<double>(m.yaw),
                static_cast<double>(m.yaw_rate)),
      now);
}

void on_attitude_target(const SetAttitudeTarget& m, FcuCore& core, RunTime now) {
  using A = AttitudeTargetTypemask;
  if (has(m.type_mask, A::kAttitudeIgnore) || has(m.type_mask, A::kThrottleIgnore)) return;
  AttitudeSetpoint setpoint;
  setpoint.q_ND = Eigen::Quaterniond(static_cast<double>(m.q[0]), static_cast<double>(m.q[1]),
                                     static_cast<double>(m.q[2]), static_cast<double>(m.q[3]));
  // One number that is none would stay in the integrators for good.
  if (!(setpoint.q_ND.norm() > 0.5) || !setpoint.q_ND.coeffs().allFinite()) return;
  if (!std::isfinite(m.thrust)) return;
  setpoint.q_ND.normalize();
  const double thrust = std::clamp(static_cast<double>(m.thrust), 0.0, 1.0);
  setpoint.thrust_n = thrust * core.config.vehicle.scales.u1_max_n;
  if (!has(m.type_mask, A::kBodyYawRateIgnore) && std::isfinite(m.body_yaw_rate)) {
    setpoint.yaw_rate_rad_s = static_cast<double>(m.body_yaw_rate);
  }
  core.commander.offboard().on_attitude(setpoint, now);
}

void on_manual_control(const ManualControl& m, FcuCore& core, RunTime now) {
  if (m.target != 0 && m.target != core.config.system_id) return;
  ManualInput& input = core.manual_control;
  input.sticks.pitch = unit(m.x);
  input.sticks.roll = unit(m.y);
  input.sticks.yaw = unit(m.r);
  input.sticks.throttle = std::clamp(m.z / 1000.0, 0.0, 1.0);
  input.last = now;
  input.seen = true;
}

void on_rc_inputs(const HilRcInputsRaw& m, FcuCore& core, RunTime now) {
  take_channels(m.chan1_raw, m.chan2_raw, m.chan3_raw, m.chan4_raw, core.rc_input, now);
}

void on_rc_override(const RcChannelsOverride& m, FcuCore& core, RunTime now) {
  take_channels(m.chan1_raw, m.chan2_raw, m.chan3_raw, m.chan4_raw, core.rc_input, now);
}

}  // namespace cas::fcu
