// SPDX-License-Identifier: BSD-3-Clause
#include "libsim/hilsim/wind_tunnel.hpp"

#include <fmt/format.h>

#include <Eigen/Core>
#include <array>
#include <cmath>
#include <iterator>
#include <span>

#include "base/angles.hpp"
#include "base/config/config.hpp"
#include "base/config/vehicle.hpp"
#include "base/earth/atmosphere.hpp"
#include "base/earth/frames.hpp"
#include "plugins/aero/aero_model.hpp"

namespace cas::sim {
namespace {

/// The model in air from one direction.
class WindTunnel {
 public:
  WindTunnel(const base::AeroParams& aero, double airspeed_m_s)
      : model_(aero), surfaces_(aero.surfaces.size()), reference_(PolarReference::of(aero)) {
    air_.air_density_kg_m3 = base::isa::density_kg_m3(0);
    speed_m_s_ = airspeed_m_s;
    pressure_pa_ = 0.5 * air_.air_density_kg_m3 * airspeed_m_s * airspeed_m_s;
  }

  /// CL, CD, CY, Cl, Cm, Cn.
  std::array<double, 6> coefficients(double alpha_rad, double beta_rad) const {
    const double cos_a = std::cos(alpha_rad);
    const double sin_a = std::sin(alpha_rad);
    const Eigen::Vector3d v_D(cos_a * std::cos(beta_rad), std::sin(beta_rad),
                              sin_a * std::cos(beta_rad));
    BodyState body;
    body.v_WB = speed_m_s_ * base::swap_BD(v_D);
    const std::array<double, base::kMaxOutputs> neutral{};
    std::array<double, base::kMaxOutputs> ignored{};
    Wrench wrench;
    model_.evaluate(body, air_, std::span(neutral).first(surfaces_),
                    std::span(ignored).first(surfaces_), wrench);
    const double force_n = pressure_pa_ * reference_.area_m2;
    const Eigen::Vector3d force = base::swap_BD(wrench.force_B) / force_n;
    const Eigen::Vector3d torque_m = base::swap_BD(wrench.torque_B) / force_n;
    return {force.x() * sin_a - force.z() * cos_a,
            -force.x() * cos_a - force.z() * sin_a,
            force.y(),
            torque_m.x() / reference_.span_m,
            torque_m.y() / reference_.chord_m,
            torque_m.z() / reference_.span_m};
  }

 private:
  AeroModel model_;
  std::size_t surfaces_;
  PolarReference reference_;
  Environment air_;
  double speed_m_s_ = 0;
  double pressure_pa_ = 0;
};

}  // namespace

std::vector<double> AngleSweep::angles_deg(const std::string& flag, double limit_deg) const {
  constexpr double kMostAngles = 10'000;
  constexpr double kRounding = 1e-9;  // of a step
  if (!(step_deg > 0) || !(first_deg <= last_deg) || !(first_deg >= -limit_deg) ||
      !(last_deg <= limit_deg) || (last_deg - first_deg) / step_deg >= kMostAngles) {
    throw base::ConfigError(
        fmt::format("{} takes FROM TO STEP in deg, such as -10 20 0.5: from -{:g} to {:g}, at most "
                    "{:g} angles",
                    flag, limit_deg, limit_deg, kMostAngles));
  }
  const auto steps = static_cast<int>((last_deg - first_deg) / step_deg + kRounding);
  std::vector<double> angles;
  for (int i = 0; i <= steps; ++i) angles.push_back(first_deg + i * step_deg);
  return angles;
}

PolarReference PolarReference::of(const base::AeroParams& aero) {
  if (const auto& body = aero.derivatives) {
    return {.area_m2 = body->area_m2, .span_m = body->span_m, .chord_m = body->chord_m};
  }
  constexpr double kUpwards = 0.5;  // of a panel's normal
  PolarReference reference{.area_m2 = 0, .span_m = 1, .chord_m = 1};
  for (const base::PanelParams& panel : aero.panels) {
    if (std::abs(panel.normal_B.z()) >= kUpwards) reference.area_m2 += panel.area_m2;
  }
  if (reference.area_m2 <= 0) reference.area_m2 = 1;
  return reference;
}

std::string polar_csv(const base::AeroParams& aero, double airspeed_m_s,
                      const std::vector<double>& alphas_deg, const std::vector<double>& betas_deg) {
  const WindTunnel tunnel(aero, airspeed_m_s);
  std::string text = "alpha_deg,beta_deg,CL,CD,CY,Cl,Cm,Cn\n";
  for (const double beta : betas_deg) {
    for (const double alpha : alphas_deg) {
      fmt::format_to(std::back_inserter(text), "{},{}", alpha, beta);
      for (const double each : tunnel.coefficients(base::radians(alpha), base::radians(beta))) {
        fmt::format_to(std::back_inserter(text), ",{}", each + 0.0);  // + 0.0: no "-0"
      }
      text += '\n';
    }
  }
  return text;
}

}  // namespace cas::sim
