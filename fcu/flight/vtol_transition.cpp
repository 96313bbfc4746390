// SPDX-License-Identifier: BSD-3-Clause
#include "fcu/flight/vtol_transition.hpp"

#include <algorithm>
#include <cmath>

#include "base/earth/atmosphere.hpp"
#include "base/earth/frames.hpp"
#include "base/earth/gravity.hpp"
#include "base/enum_words.hpp"

namespace cas::fcu {

std::string_view name(VtolState state) {
  constexpr base::EnumWords<VtolState::kToMulticopter> kWords{"multicopter", "to_plane", "plane",
                                                              "to_multicopter"};
  return kWords[state];
}

VtolTransition::VtolTransition(const base::Vehicle& vehicle)
    : figures_(vehicle.aero ? WingFigures::of(*vehicle.aero) : WingFigures{}),
      weight_n_(vehicle.mass_kg * base::kStandardGravity_m_s2) {}

void VtolTransition::begin(bool to_plane, const TaskContext& context) {
  const VtolState wanted = to_plane ? VtolState::kPlane : VtolState::kMulticopter;
  const VtolState way = to_plane ? VtolState::kToPlane : VtolState::kToMulticopter;
  if (state_ == wanted || state_ == way) return;
  if (!under_way()) z_m_ = context.estimate.p_N.z();
  state_ = way;
  time_s_ = 0;
  gave_up_ = false;
  yaw_rad_ = context.yaw_rad;
}

std::optional<VtolState> VtolTransition::update(const TaskContext& context) {
  constexpr double kHovers_m_s = 4;  // over ground: the rotors brake the rest
  const WingParams& p = context.wing;
  time_s_ += context.dt;
  if (state_ == VtolState::kToPlane) {
    if (context.airspeed.equivalent_m_s >= p.transition_airspeed_m_s) {
      state_ = VtolState::kPlane;
      return state_;
    }
    if (time_s_ < p.transition_timeout_s) return std::nullopt;
    begin(false, context);
    gave_up_ = true;
    return std::nullopt;
  }
  const double speed = context.estimate.v_N.head<2>().norm();
  if (speed > kHovers_m_s && time_s_ < p.back_transition_s) return std::nullopt;
  state_ = VtolState::kMulticopter;
  return state_;
}

double VtolTransition::pressure_pa(const TaskContext& context) const {
  return base::isa::density_kg_m3(0) / 2 * std::pow(context.airspeed.equivalent_m_s, 2);
}

/// That of the angle of attack that carries the weight: on the way to the wing from the blend
/// airspeed on; on the way back it brakes, too.
double VtolTransition::pitch_rad(const TaskContext& context) const {
  constexpr double kMost_rad = 7 * base::kRadPerDeg;
  const double beyond_m_s = context.airspeed.equivalent_m_s - context.wing.blend_airspeed_m_s;
  const double share = state_ == VtolState::kToPlane ? std::clamp(beyond_m_s, 0.0, 1.0) : 1.0;
  const double pressure = std::max(pressure_pa(context), 1.0);
  const double alpha = figures_.angle_of_attack_rad(weight_n_, pressure);
  return share * std::clamp(alpha, -kMost_rad, kMost_rad);
}

ControlSetpoint VtolTransition::setpoint(const TaskContext& context) const {
  constexpr double kThrottleUp_s = 0.5;
  const double pitch = pitch_rad(context);
  ControlSetpoint out;
  // The rotors keep the height, whatever the wing carries ...
  out.trajectory = TrajectorySetpoint{};
  out.trajectory->p_N.z() = z_m_;
  out.trajectory->v_N.z() = 0;
  out.trajectory->yaw_rad = yaw_rad_;
  out.attitude = AttitudeSetpoint{.q_ND = base::quaternion_rpy(0, pitch, yaw_rad_)};
  out.thrust_min_n = 0;
  const double now_rad = base::euler_rpy(context.estimate.q_ND).y();
  const double lift =
      pressure_pa(context) * figures_.lift_slope_m2 * (now_rad - figures_.zero_lift_rad);
  out.wing_lift_n = std::clamp(lift, 0.0, weight_n_);
  // ... and surfaces and throttle do the rest.
  WingSetpoint wing;
  wing.roll_rad = 0;
  wing.pitch_rad = wing.alpha_rad = pitch;
  wing.throttle = state_ == VtolState::kToPlane
                      ? context.wing.transition_throttle * std::min(time_s_ / kThrottleUp_s, 1.0)
                      : 0.0;
  wing.unloaded = true;
  out.wing = wing;
  return out;
}

}  // namespace cas::fcu
