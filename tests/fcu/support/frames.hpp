// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cmath>
#include <string>
#include <vector>

#include "base/config/vehicle.hpp"
#include "tests/support/paths.hpp"

namespace cas::fcu::test {

/// Airframes of the rotors of iris_paper, made up for tests.
inline base::Vehicle frame(const std::string& name, const std::vector<base::Rotor>& rotors,
                           double mass_kg, const Eigen::Vector3d& inertia_kg_m2) {
  base::Vehicle vehicle =
      base::Vehicle::load(cas::test::source_dir() + "/config/vehicles/iris_paper.yaml");
  const base::RotorParams params = vehicle.rotors.front().params;
  vehicle.name = name;
  vehicle.mass_kg = mass_kg;
  vehicle.inertia_kg_m2 = inertia_kg_m2;
  vehicle.rotors = rotors;
  for (std::size_t i = 0; i < vehicle.rotors.size(); ++i) {
    vehicle.rotors[i].params = params;
    vehicle.rotors[i].output = static_cast<int>(i);
  }
  vehicle.scales = vehicle.control_scales();
  return vehicle;
}

inline base::Rotor rotor(double arm_m, double angle_deg, int spin) {
  const double angle = angle_deg * M_PI / 180;  // from Bx to the left
  base::Rotor out;
  out.position_B_m = {arm_m * std::cos(angle), arm_m * std::sin(angle), 0.02};
  out.spin = spin;
  return out;
}

/// Rotors at equal distances on a circle, from the front to the left.
inline std::vector<base::Rotor> ring(double arm_m, double first_deg,
                                     const std::vector<int>& spins) {
  std::vector<base::Rotor> out;
  const double step_deg = 360.0 / static_cast<double>(spins.size());
  for (std::size_t i = 0; i < spins.size(); ++i) {
    out.push_back(rotor(arm_m, first_deg + step_deg * static_cast<double>(i), spins[i]));
  }
  return out;
}

/// Spins that alternate.
inline base::Vehicle hexa_x() {
  return frame("hexa_x", ring(0.3, 30, {1, -1, 1, -1, 1, -1}), 2.3, {0.06, 0.06, 0.11});
}

inline base::Vehicle octo_x() {
  return frame("octo_x", ring(0.35, 22.5, {1, -1, 1, -1, 1, -1, 1, -1}), 3.1, {0.11, 0.11, 0.2});
}

/// Pairs on each arm; the lower rotor keeps a share of its thrust.
inline base::Vehicle coaxial(const std::string& name, const std::vector<double>& arms_deg,
                             double mass_kg, const Eigen::Vector3d& inertia_kg_m2) {
  constexpr double kShareInWake = 0.8;
  std::vector<base::Rotor> rotors;
  for (const double arm : arms_deg) {
    rotors.push_back(rotor(0.3, arm, 1));
    rotors.push_back(rotor(0.3, arm, -1));
    rotors.back().position_B_m.z() -= 0.06;
    rotors.back().wake = base::Wake{static_cast<int>(rotors.size()) - 2, kShareInWake};
  }
  return frame(name, rotors, mass_kg, inertia_kg_m2);
}

inline base::Vehicle y6() { return coaxial("y6", {60, 180, 300}, 2.0, {0.05, 0.05, 0.09}); }
inline base::Vehicle x8() { return coaxial("x8", {45, 135, 225, 315}, 2.8, {0.06, 0.06, 0.11}); }

/// Two rotors in front, one at the tail that a servo tilts to the left and right.
inline base::Vehicle tri() {
  std::vector<base::Rotor> rotors{rotor(0.3, 60, 1), rotor(0.3, 300, -1), rotor(0.3, 180, 1)};
  rotors.back().tilt = base::TiltServo{.axis_B = Eigen::Vector3d::UnitX(),
                                       .min_rad = -0.6,
                                       .max_rad = 0.6,
                                       .rate_rad_s = 8,
                                       .output = 3};
  return frame("tri", rotors, 1.15, {0.02, 0.02, 0.035});
}

/// A hexarotor whose rotors lean to the sides of their arms, in turn.
inline base::Vehicle tilted_hexa(double lean_rad) {
  std::vector<base::Rotor> rotors = ring(0.3, 30, {1, -1, 1, -1, 1, -1});
  double sign = 1;
  for (base::Rotor& rotor : rotors) {
    const Eigen::Vector3d arm_B(rotor.position_B_m.x(), rotor.position_B_m.y(), 0);
    rotor.axis_B = Eigen::AngleAxisd(sign * lean_rad, arm_B.normalized()) * rotor.axis_B;
    sign = -sign;
  }
  return frame("tilted_hexa", rotors, 2.3, {0.06, 0.06, 0.11});
}

}  // namespace cas::fcu::test
