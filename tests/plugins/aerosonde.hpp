// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cmath>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "base/config/vehicle.hpp"
#include "plugins/aero/aero_model.hpp"
#include "plugins/aero/trim.hpp"
#include "tests/support/paths.hpp"

namespace cas::test {

/// The shipped Aerosonde, or a plane of the tests.
inline base::Vehicle load_plane(const std::string& name) {
  const char* folder = name == "aerosonde" ? "/config/vehicles/" : "/tests/plugins/data/";
  return base::Vehicle::load(source_dir() + folder + name + ".yaml");
}

/// Thrust (N), torque (N m) and speed (rad/s) of the Aerosonde's propeller and electric motor.
struct PropellerLoad {
  double thrust_n = 0;
  double torque_nm = 0;
  double omega_rad_s = 0;
};

/// The closed form of [Beard] Sect. 4.3: a 20 in propeller whose coefficients are quadratic in the
/// advance ratio, on a motor of 145 rpm/V, 0.042 ohm and 1.5 A, fed by 44.4 V at full throttle.
inline PropellerLoad aerosonde_propeller(double airspeed_m_s, double throttle, double density) {
  constexpr double kDiameter_m = 20 * 0.0254;
  const double kv = 60 / (2 * M_PI) / 145;
  constexpr double kResistance_ohm = 0.042;
  constexpr double kIdle_a = 1.5;
  constexpr double kFull_v = 44.4;
  constexpr double kTorque[]{0.005230, 0.004970, -0.01664};
  constexpr double kThrust[]{0.09357, -0.06044, -0.1079};
  const double d3 = std::pow(kDiameter_m, 3);
  const double a = density * d3 * kDiameter_m * kDiameter_m / (4 * M_PI * M_PI) * kTorque[0];
  const double b = density * d3 * kDiameter_m / (2 * M_PI) * kTorque[1] * airspeed_m_s +
                   kv * kv / kResistance_ohm;
  const double c = density * d3 * kTorque[2] * airspeed_m_s * airspeed_m_s -
                   kv / kResistance_ohm * kFull_v * throttle + kv * kIdle_a;
  const double omega = (-b + std::sqrt(b * b - 4 * a * c)) / (2 * a);
  const double j = 2 * M_PI * airspeed_m_s / (omega * kDiameter_m);
  const double n2 = omega * omega / (4 * M_PI * M_PI);
  const double scale = density * n2 * d3 * kDiameter_m;
  return {scale * (kThrust[0] + kThrust[1] * j + kThrust[2] * j * j),
          scale * kDiameter_m * (kTorque[0] + kTorque[1] * j + kTorque[2] * j * j), omega};
}

/// The Aerosonde in the air and gravity of the book.
inline sim::Airframe aerosonde() {
  const base::Vehicle vehicle = load_plane("aerosonde");
  sim::Airframe airframe;
  airframe.mass_kg = 11;
  airframe.inertia_B << 0.8244, 0, 0.1204, 0, 1.135, 0, 0.1204, 0, 1.759;
  airframe.air.gravity_W = {0, 0, -9.81};
  airframe.air.air_density_kg_m3 = 1.2682;
  airframe.surfaces = vehicle.aero->surfaces.size();
  const auto model = std::make_shared<sim::AeroModel>(*vehicle.aero);
  airframe.wrench = [model, air = airframe.air](const sim::BodyState& body,
                                                std::span<const double> deflections,
                                                double throttle) {
    sim::Wrench wrench;
    std::vector<double> rates(deflections.size());
    model->evaluate(body, air, deflections, rates, wrench);
    const auto load = aerosonde_propeller(body.v_WB.norm(), throttle, air.air_density_kg_m3);
    wrench.force_B.x() += load.thrust_n;
    wrench.torque_B.x() -= load.torque_nm;
    return wrench;
  };
  return airframe;
}

}  // namespace cas::test
