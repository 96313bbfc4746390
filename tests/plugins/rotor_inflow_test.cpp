// SPDX-License-Identifier: BSD-3-Clause
// Rotors in air from any side, against closed forms and against wind tunnels.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "plugins/motor/rotor_inflow.hpp"

namespace cas::sim {
namespace {

constexpr double kClosedForm = 1e-9;

TEST(MomentumTheory, IsTheClosedFormsOfHoverClimbAndFastSink) {
  EXPECT_NEAR(induced_velocity({}), 1, kClosedForm);
  for (const double climb : {-0.9, 0.3, 1.5, 4.0}) {
    EXPECT_NEAR(induced_velocity({.climb = climb}), -climb / 2 + std::sqrt(climb * climb / 4 + 1),
                kClosedForm)
        << climb;
  }
  for (const double climb : {-2.2, -3.0, -8.0}) {
    EXPECT_NEAR(induced_velocity({.climb = climb}), -climb / 2 - std::sqrt(climb * climb / 4 - 1),
                kClosedForm)
        << climb;
  }
}

TEST(MomentumTheory, IsGlauertsInEdgewiseFlow) {
  for (const double edgewise : {0.2, 1.0, 3.0}) {
    const double square = edgewise * edgewise;
    EXPECT_NEAR(induced_velocity({.edgewise = edgewise}),
                std::sqrt(-square / 2 + std::sqrt(square * square / 4 + 1)), kClosedForm);
  }
  // v_i -> T / (2 rho A V), the wing of an elliptic lift.
  EXPECT_NEAR(20 * induced_velocity({.edgewise = 20}), 1, 1e-5);
  // A disc that leans: the quartic v^2 (x^2 + (z + v)^2) = 1.
  for (const RotorAir air : {RotorAir{0.5, 1.5}, RotorAir{-0.5, 1}, RotorAir{2, 2}}) {
    const double v = induced_velocity(air);
    EXPECT_NEAR(v * std::hypot(air.edgewise, air.climb + v), 1, kClosedForm);
  }
}

TEST(MomentumTheory, TakesJohnsonsFitInTheVortexRing) {
  for (const double climb : {-1.2, -1.5, -1.8}) {
    EXPECT_NEAR(induced_velocity({.climb = climb}), climb * (0.373 * climb * climb - 1.991),
                kClosedForm);
  }
  EXPECT_NEAR(induced_velocity({.climb = -1.5, .edgewise = 0.5}),
              -1.5 * (0.373 * 2.25 + 0.598 * 0.25 - 1.991), kClosedForm);
}

TEST(MomentumTheory, ThrustRisesSmoothlyWithTheInducedVelocity) {
  constexpr double kStep = 1e-4;
  constexpr double kBend = 0.02;  // less than a corner; the borders of the fit bend by 0.012
  for (double edgewise = 0; edgewise < 1.5; edgewise += 0.05) {
    const RotorAir air{.climb = -1, .edgewise = edgewise};
    double rate = (momentum_thrust(-1, air) - momentum_thrust(-1 - kStep, air)) / kStep;
    double least = rate;
    double most_bent = 0;
    for (double v = -1; v < 2; v += kStep) {
      const double next = (momentum_thrust(v + kStep, air) - momentum_thrust(v, air)) / kStep;
      least = std::min(least, next);
      most_bent = std::max(most_bent, std::abs(next - rate));
      rate = next;
    }
    EXPECT_GT(least, 0) << edgewise;
    EXPECT_LT(most_bent, kBend) << edgewise;
  }
}

/// Slopes from one of thin blades to one of broad ones, air from any side.
TEST(RotorInflow, BladesAndMomentumAgreeForAllAir) {
  for (const double slope : {0.01, 0.3, 0.7, 1.3, 5.0, 10.0}) {
    for (double climb = -12; climb < 12; climb += 0.23) {
      for (double edgewise = 0; edgewise < 12; edgewise += 0.31) {
        const RotorAir air{climb, edgewise};
        const double mu = 0.05 * edgewise;
        const RotorInflow inflow = rotor_inflow(slope, mu, air);
        EXPECT_NEAR(momentum_thrust(inflow.induced, air) / (1 + std::abs(inflow.thrust)),
                    inflow.thrust / (1 + std::abs(inflow.thrust)), 1e-10);
        EXPECT_NEAR(inflow.thrust,
                    (1 + slope) * (1 + 1.5 * mu * mu) - slope * (climb + inflow.induced), 1e-9);
      }
    }
  }
}

TEST(RotorInflow, IsTheCalibrationInHoverAndTheQuadraticInClimb) {
  for (const double slope : {0.3, 0.7, 1.3}) {
    EXPECT_NEAR(rotor_inflow(slope, 0, {}).thrust, 1, kClosedForm);
    EXPECT_NEAR(rotor_inflow(slope, 0, {}).induced, 1, kClosedForm);
    // With s = z / 2 + v: s^2 + g s = z^2 / 4 + 1 + g - g z / 2.
    for (const double climb : {0.1, 0.5, 1.0, 1.4}) {
      const double right = climb * climb / 4 + 1 + slope - slope * climb / 2;
      const double s = (-slope + std::sqrt(slope * slope + 4 * right)) / 2;
      EXPECT_NEAR(rotor_inflow(slope, 0, {.climb = climb}).thrust, s * s - climb * climb / 4,
                  kClosedForm);
    }
    // No thrust where the blades meet the air flat.
    EXPECT_NEAR(rotor_inflow(slope, 0, {.climb = 1 + 1 / slope}).thrust, 0, kClosedForm);
  }
  // The calibration counts for torque, too.
  const RotorLoad hover = rotor_load({.slope = 0.7,
                                      .radius_m = 0.127,
                                      .omega_rad_s = 500,
                                      .density_kg_m3 = 1.225,
                                      .hover_thrust_n = 3,
                                      .hover_torque_n_m = 0.05});
  EXPECT_NEAR(hover.thrust, 1, kClosedForm);
  EXPECT_NEAR(hover.torque, 1, kClosedForm);
}

TEST(RotorInflow, ChangesSmoothlyThroughHoverAndAcrossTheVortexRing) {
  constexpr double kStep = 1e-3;
  for (const double edgewise : {0.0, 0.3, 1.0}) {
    const auto thrust = [&](double climb) {
      return rotor_inflow(0.7, 0, {.climb = climb, .edgewise = edgewise}).thrust;
    };
    for (double climb = -4; climb < 3; climb += kStep) {
      EXPECT_NEAR(thrust(climb + kStep), thrust(climb), 2 * kStep) << climb;
    }
    const double above = (thrust(2 * kStep) - thrust(kStep)) / kStep;
    const double below = (thrust(-kStep) - thrust(-2 * kStep)) / kStep;
    EXPECT_NEAR(above, below, 5 * kStep) << "no bend in hover";
  }
}

/// Propeller of the UIUC Propeller Database, volume 1 (J. B. Brandt, R. W. Deters, G. K. Ananda, O.
/// D. Dantsker, M. S. Selig): thrust T = C_T rho n^2 D^4, power P = C_P rho n^3 D^5, V = J n D.
struct Tunnel {
  double advance;  // J
  double thrust;   // C_T
  double power;    // C_P
};

struct Propeller {
  double diameter_m;
  double rev_s;
  double thrust;     // C_T without wind
  double power;      // C_P
  double no_thrust;  // J where thrust vanishes
};

/// C_T and C_P that the model gives.
Tunnel predict(const Propeller& propeller, double advance) {
  constexpr double kDensity = 1.225;
  const double n = propeller.rev_s;
  const double d = propeller.diameter_m;
  const double thrust_n = propeller.thrust * kDensity * n * n * std::pow(d, 4);
  const double v_hover = std::sqrt(thrust_n / (2 * kDensity * M_PI * d * d / 4));
  const RotorLoad load = rotor_load(
      {.slope = 1 / (propeller.no_thrust * n * d / v_hover - 1),
       .radius_m = d / 2,
       .omega_rad_s = 2 * M_PI * n,
       .density_kg_m3 = kDensity,
       .hover_thrust_n = thrust_n,
       .hover_torque_n_m = propeller.power * kDensity * n * n * std::pow(d, 5) / (2 * M_PI),
       .climb_m_s = advance * n * d});
  return {advance, load.thrust * propeller.thrust, load.torque * propeller.power};
}

/// APC 10x4.7 SF; the slope is that of the measured J without thrust.
TEST(RotorInflow, ClimbsLikeAPropellerInTheTunnelOfUiuc) {
  // apcsf_10x4.7_static_kt0835 (between its rows) and apcsf_10x4.7_kt0836_4014.
  const Propeller slow{0.254, 4014 / 60.0, 0.1157, 0.0465, 0.643};
  const std::vector<Tunnel> slow_runs{
      {0.142, 0.0994, 0.0451},  {0.177, 0.0944, 0.0446}, {0.216, 0.0885, 0.0436},
      {0.255, 0.0829, 0.0427},  {0.289, 0.0770, 0.0414}, {0.325, 0.0719, 0.0407},
      {0.361, 0.0652, 0.0392},  {0.399, 0.0582, 0.0375}, {0.438, 0.0502, 0.0352},
      {0.468, 0.0441, 0.0335},  {0.510, 0.0343, 0.0308}, {0.534, 0.0288, 0.0292},
      {0.577, 0.0178, 0.0258},  {0.612, 0.0083, 0.0228}, {0.647, -0.0011, 0.0199},
      {0.685, -0.0122, 0.0162}, {0.719, -0.0218, 0.0130}};
  // apcsf_10x4.7_static_kt0835, apcsf_10x4.7_rd0841_6512; no thrust: apcsf_10x4.7_rd0840_6020.
  const Propeller fast{0.254, 6512 / 60.0, 0.1299, 0.0531, 0.658};
  const std::vector<Tunnel> fast_runs{
      {0.089, 0.1201, 0.0523}, {0.112, 0.1171, 0.0522}, {0.134, 0.1129, 0.0512},
      {0.155, 0.1101, 0.0511}, {0.176, 0.1059, 0.0500}, {0.199, 0.1019, 0.0493},
      {0.225, 0.0974, 0.0483}, {0.246, 0.0935, 0.0475}, {0.266, 0.0895, 0.0465},
      {0.287, 0.0865, 0.0460}, {0.308, 0.0833, 0.0454}, {0.332, 0.0787, 0.0444},
      {0.357, 0.0743, 0.0434}, {0.378, 0.0704, 0.0424}, {0.395, 0.0669, 0.0414},
      {0.420, 0.0616, 0.0398}, {0.445, 0.0562, 0.0381}};
  for (const auto& [propeller, runs] : {std::pair(slow, slow_runs), std::pair(fast, fast_runs)}) {
    for (const Tunnel& run : runs) {
      const Tunnel model = predict(propeller, run.advance);
      EXPECT_NEAR(model.thrust, run.thrust, 0.05 * propeller.thrust) << run.advance;
      // Near no thrust the blades' drag is larger than in hover, and more so in the wind that turns
      // them: there the model has too little power.
      if (run.advance > 0.5) continue;
      EXPECT_NEAR(model.power, run.power, 0.08 * run.power) << run.advance;
    }
  }
}

/// A DJI Phantom 3 Advanced in the U.S. Army's 7- by 10-ft wind tunnel and hovering in a
/// laboratory: C. Russell, J. Jung, G. Willink, B. Glasner, Wind Tunnel and Hover Performance Test
/// Results for Multicopter UAS Vehicles, NASA/TM-2018-219758, Table C18 and run 27, in the units of
/// WEMUAV (github.com/meierkilian/WEMUAV, para/Russell_drag_6ms.csv and Russell_hover.csv).
struct Phantom {
  double wind_m_s;
  double nose_down_rad;
  double rev_min;
  double thrust_n;  // along the rotors' axes, of four rotors and the body
  double power_w;   // of the speed controllers
};

constexpr double kTunnelDensity = 1.221;  // kg/m^3

/// The vehicle without wind at the speed of a run, in the tunnel's air.
Phantom hover_at(double rev_min) {
  constexpr double kLaboratoryDensity = 1.2266;
  const std::vector<Phantom> measured{{0, 0, 4200, 8.3315, 103.1},
                                      {0, 0, 4800, 11.0449, 152.1},
                                      {0, 0, 5300, 13.5226, 207.5},
                                      {0, 0, 5800, 16.3294, 282.8},
                                      {0, 0, 6400, 19.9503, 366.0}};
  const auto nearest =
      std::min_element(measured.begin(), measured.end(), [&](const Phantom& a, const Phantom& b) {
        return std::abs(a.rev_min - rev_min) < std::abs(b.rev_min - rev_min);
      });
  const double speed = rev_min / nearest->rev_min;
  const double density = kTunnelDensity / kLaboratoryDensity;
  return {0, 0, rev_min, density * speed * speed * nearest->thrust_n,
          density * speed * speed * speed * nearest->power_w};
}

TEST(RotorInflow, FliesForwardLikeAQuadrotorInTheTunnelOfNasa) {
  const std::vector<Phantom> runs{
      {6.547, 0.6973, 4200, 6.276, 99.8},    {6.614, 0.6973, 4800, 8.745, 146.0},
      {6.325, 0.6973, 5300, 11.485, 201.6},  {6.431, 0.6973, 5800, 14.079, 262.2},
      {6.459, 0.6973, 6400, 17.753, 350.7},  {6.322, 0.5226, 4200, 7.446, 102.0},
      {6.395, 0.5226, 4800, 10.115, 149.4},  {6.440, 0.5226, 5300, 12.651, 201.9},
      {6.450, 0.5226, 5800, 15.337, 260.8},  {6.471, 0.5226, 6400, 19.101, 348.8},
      {6.511, 0.3477, 4300, 8.785, 109.1},   {6.535, 0.3475, 4800, 11.023, 147.7},
      {6.532, 0.3477, 5300, 13.696, 200.4},  {6.581, 0.3475, 5800, 16.574, 257.9},
      {6.596, 0.3477, 6400, 20.448, 344.7},  {6.309, 0.1730, 4200, 9.119, 100.4},
      {6.148, 0.1728, 4800, 11.810, 146.1},  {6.364, 0.1728, 5300, 14.612, 194.1},
      {6.450, 0.1728, 5800, 17.557, 254.0},  {6.398, 0.1728, 6400, 21.245, 337.2},
      {6.349, 0.0869, 4200, 9.648, 98.9},    {6.389, 0.0869, 4800, 12.299, 142.8},
      {6.376, 0.0869, 5300, 15.182, 195.2},  {6.361, 0.0869, 5800, 17.824, 252.5},
      {6.331, 0.0869, 6400, 21.605, 338.3},  {6.407, 0.0346, 4200, 9.724, 97.1},
      {6.431, 0.0346, 4800, 12.584, 142.5},  {6.386, 0.0346, 5300, 15.386, 200.2},
      {6.373, 0.0346, 5800, 18.135, 253.4},  {6.380, 0.0346, 6400, 22.116, 343.2},
      {6.398, -0.0021, 4200, 9.951, 97.6},   {6.428, -0.0021, 4800, 12.753, 143.0},
      {6.361, -0.0021, 5300, 15.529, 196.5}, {6.346, -0.0021, 5800, 18.340, 251.7},
      {6.285, -0.0021, 6400, 22.343, 342.7}};
  // The one figure taken from the runs: 0.5 to 0.7 leave the same errors. The propeller is 9.4 in.
  constexpr double kSlope = 0.6;
  // Torque over thrust of a rotor alone, Table C85 at 5300 rev/min.
  constexpr double kTorque_m = 0.0572 / 3.5941;
  double thrust_squares = 0;
  double power_squares = 0;
  for (const Phantom& run : runs) {
    const Phantom hover = hover_at(run.rev_min);
    const RotorLoad load = rotor_load({.slope = kSlope,
                                       .radius_m = 0.1194,
                                       .omega_rad_s = run.rev_min * M_PI / 30,
                                       .density_kg_m3 = kTunnelDensity,
                                       .hover_thrust_n = hover.thrust_n / 4,
                                       .hover_torque_n_m = kTorque_m * hover.thrust_n / 4,
                                       .climb_m_s = run.wind_m_s * std::sin(run.nose_down_rad),
                                       .edgewise_m_s = run.wind_m_s * std::cos(run.nose_down_rad)});
    const double thrust_error = load.thrust - run.thrust_n / hover.thrust_n;
    const double power_error = load.torque - run.power_w / hover.power_w;
    // Thrust in this wind is 0.76 to 1.20 of that in hover.
    EXPECT_LT(std::abs(thrust_error), 0.045) << run.nose_down_rad << " " << run.rev_min;
    EXPECT_LT(std::abs(power_error), 0.1) << run.nose_down_rad << " " << run.rev_min;
    thrust_squares += thrust_error * thrust_error;
    power_squares += power_error * power_error;
  }
  const auto count = static_cast<double>(runs.size());
  EXPECT_LT(std::sqrt(thrust_squares / count), 0.02);
  EXPECT_LT(std::sqrt(power_squares / count), 0.055);
  RecordProperty("thrust_rms", std::to_string(std::sqrt(thrust_squares / count)));
  RecordProperty("power_rms", std::to_string(std::sqrt(power_squares / count)));
}

}  // namespace
}  // namespace cas::sim
