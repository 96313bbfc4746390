// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

#include "base/config/vehicle.hpp"
#include "fcu/control/wing_airframe.hpp"
#include "fcu/flight/flight_tasks.hpp"

namespace cas::fcu {

/// What carries a VTOL.
enum class VtolState : std::uint8_t { kMulticopter, kToPlane, kPlane, kToMulticopter };

/// "multicopter", "to_plane", "plane", "to_multicopter".
std::string_view name(VtolState state);

/// Takes a VTOL from its rotors onto its wing and back, straight ahead and at one height: the
/// rotors carry what the wing does not yet carry, or no more.
///
///   to plane:       full transition throttle; from VT_ARSP_BLEND on the nose is raised to the
///   angle
///                   of attack that carries the weight; done at VT_ARSP_TRANS
///   to multicopter: no throttle, the same angles of attack; done when it is slow, or after
///                   VT_B_TRANS_DUR
class VtolTransition {
 public:
  /// @param vehicle  with a wing, and rotors that lift
  explicit VtolTransition(const base::Vehicle& vehicle);

  VtolState state() const { return state_; }
  bool under_way() const {
    return state_ == VtolState::kToPlane || state_ == VtolState::kToMulticopter;
  }
  /// Begins a transition; one that is under way turns about.
  void begin(bool to_plane, const TaskContext& context);
  /// On the ground it stands on its rotors.
  void reset() { state_ = VtolState::kMulticopter; }
  /// One control step under way. @return the state that it has come to, once
  std::optional<VtolState> update(const TaskContext& context);
  /// Whether it went back because VT_ARSP_TRANS was not reached in time.
  bool gave_up() const { return gave_up_; }
  ControlSetpoint setpoint(const TaskContext& context) const;
  void shift(const Eigen::Vector3d& by_N) { z_m_ += by_N.z(); }

 private:
  double pitch_rad(const TaskContext& context) const;
  double pressure_pa(const TaskContext& context) const;

  WingFigures figures_;
  double weight_n_;
  VtolState state_ = VtolState::kMulticopter;
  double time_s_ = 0;
  double z_m_ = 0;
  double yaw_rad_ = 0;
  bool gave_up_ = false;
};

}  // namespace cas::fcu
