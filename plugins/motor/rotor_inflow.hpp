// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace cas::sim {

/// Air past a rotor's hub over v_h, the induced velocity of the rotor in hover at the same speed:
/// v_h = sqrt(T_h / (2 rho A)).
struct RotorAir {
  double climb = 0;     ///< z: along the thrust, above 0 where the rotor climbs
  double edgewise = 0;  ///< x: in the rotor's plane, not below 0
};

/// What a rotor makes of that air.
struct RotorInflow {
  double thrust = 1;   ///< t, over the thrust in hover at the same speed
  double induced = 1;  ///< v, over v_h; through the disc flows z + v
};

/// Thrust over that of a hover with v = 1, of a rotor that induces v: t = v sqrt(x^2 + (z + v)^2)
/// (H. Glauert, A General Theory of the Autogyro, ARC R&M 1111, 1926; Leishman, Principles of
/// Helicopter Aerodynamics, 2nd ed., Ch. 2), the momentum theory of climb and of the windmill brake
/// state where x is 0.
///
/// Momentum theory has no flow in the vortex ring state. There, for 1.5 x^2 + (2 z + 3 sqrt(t))^2 <
/// t, the curve is Johnson's fit to measurements, v = z ((0.373 z^2 + 0.598 x^2) / t - 1.991) (W.
/// Johnson, NDARC, NASA/TP-2009-215402, the rotor's inflow), which meets momentum theory at the
/// border to 1 %; a cubic of the left side over t, from 1 to 1.2, blends them. t rises with v
/// everywhere, and t(-v, -z) = -t(v, z).
///
/// @param induced  v
double momentum_thrust(double induced, const RotorAir& air);

/// v of a rotor with the thrust of its hover, the inverse of momentum_thrust() at 1.
double induced_velocity(const RotorAir& air);

/// Thrust and inflow on which the blades and momentum theory agree.
///
/// Blade-element theory, averaged over the disc (Leishman, Ch. 3): C_T grows with the
/// advance ratio mu and falls linearly with the inflow, so that
///
///   t = (1 + g) (1 + 3/2 mu^2) - g (z + v),   g = sigma a / (8 lambda_h)
///
/// with v by momentum_thrust(). Exactly one v does that for any air; bisection bounds Newton's
/// method, and 1e-12 is reached after some four steps. Uneven inflow, stall, the shaking of a
/// vortex ring and the time that the wake takes are not modelled.
///
/// @param slope          g, above 0
/// @param advance_ratio  mu = edgewise speed over tip speed
RotorInflow rotor_inflow(double slope, double advance_ratio, const RotorAir& air);

/// A turning rotor and the air past its hub.
struct RotorFlight {
  double slope = 0;             ///< g
  double radius_m = 0;          ///< R
  double omega_rad_s = 0;       ///< w, above 0
  double density_kg_m3 = 0;     ///< rho
  double hover_thrust_n = 0;    ///< T_h, at this speed in still air, above 0
  double hover_torque_n_m = 0;  ///< Q_h
  double climb_m_s = 0;         ///< V, along the thrust
  double edgewise_m_s = 0;      ///< U, in the rotor's plane
};

/// Shares of the thrust and the torque in still air.
struct RotorLoad {
  double thrust = 1;
  double torque = 1;
};

/// Thrust by rotor_inflow(), torque by the power that the rotor takes (Leishman, Ch. 5):
///
///   Q w = k T v_i + T V + P_0 (1 + 4.65 mu^2)
///
/// with k = 1.15, or less where Q_h w is less than k T_h v_h, and P_0 the rest of Q_h w. A rotor
/// that the air drives has a torque below 0. The power by which the air's drag in the rotor's plane
/// turns the rotor is left out, and so is the rise of k with forward speed; they have opposite
/// signs.
///
/// Air near the speed of the tips is outside of the theory: it counts as 0.84 of itself there, and
/// never as more than the tips' speed, so that a rotor that comes to rest loses thrust and torque
/// with the square of its speed.
RotorLoad rotor_load(const RotorFlight& flight);

}  // namespace cas::sim
