// SPDX-License-Identifier: BSD-3-Clause
#include "libsim/hilsim/wing_description.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <span>
#include <utility>
#include <vector>

#include "base/angles.hpp"
#include "base/earth/atmosphere.hpp"
#include "base/earth/gravity.hpp"
#include "plugins/aero/aero_model.hpp"
#include "plugins/aero/flight_modes.hpp"
#include "plugins/aero/glide_polar.hpp"
#include "plugins/aero/trim.hpp"
#include "plugins/motor/body_drag.hpp"
#include "plugins/motor/rotor_model.hpp"

namespace cas::sim {
namespace {

/// Tilt at which a rotor's axis points forwards most; 0 without a servo.
double forward_tilt_rad(const base::Rotor& rotor) {
  if (!rotor.tilt) return 0;
  const auto forwards = [&](double tilt_rad) { return rotor.tilted_axis_B(tilt_rad).x(); };
  const double end_rad = forwards(rotor.tilt->max_rad) > forwards(rotor.tilt->min_rad)
                             ? rotor.tilt->max_rad
                             : rotor.tilt->min_rad;
  return forwards(end_rad) > forwards(0) ? end_rad : 0;
}

/// The rotors that push forwards, turning as fast as they do in the end at a throttle; servos tilt
/// theirs as far forwards as they go.
class PushingRotors {
 public:
  explicit PushingRotors(const base::Vehicle& vehicle) : vehicle_(vehicle), model_(vehicle) {
    base::RotorVector tilts(vehicle.rotor_count());
    for (std::size_t i = 0; i < vehicle.rotors.size(); ++i) {
      tilts[static_cast<Eigen::Index>(i)] = forward_tilt_rad(vehicle.rotors[i]);
    }
    model_.set_tilt_targets(tilts);
  }

  void add(const BodyState& body, const Environment& air, double throttle, Wrench& wrench) {
    model_.set_targets(targets(throttle));
    std::array<double, ForceModel::kMaxStates> x{};
    std::array<double, ForceModel::kMaxStates> x_dot{};
    const auto count = static_cast<std::size_t>(model_.state_count());
    settle(body, air, std::span(x).first(count));
    model_.evaluate(body, air, std::span(x).first(count), std::span(x_dot).first(count), wrench);
  }

 private:
  base::RotorVector targets(double throttle) const {
    constexpr double kForwards = 0.5;  // of a rotor's axis
    base::RotorVector omega = base::RotorVector::Zero(vehicle_.rotor_count());
    for (std::size_t i = 0; i < vehicle_.rotors.size(); ++i) {
      const base::Rotor& rotor = vehicle_.rotors[i];
      if (rotor.tilted_axis_B(forward_tilt_rad(rotor)).x() < kForwards) continue;
      omega[static_cast<Eigen::Index>(i)] = rotor.speed_at(throttle);
    }
    return omega;
  }

  /// Newton's method for each speed on its own: they depend on each other little or not at all.
  void settle(const BodyState& body, const Environment& air, std::span<double> x) const {
    constexpr int kMostSteps = 50;
    constexpr double kStep_rad_s = 1e-3;
    constexpr double kSteady_rad_s2 = 1e-10;
    model_.initial_states(x);
    const base::RotorVector omega = model_.targets();
    for (Eigen::Index i = 0; i < omega.size(); ++i) x[static_cast<std::size_t>(i)] = omega[i];
    std::size_t servo = vehicle_.rotors.size();  // its state
    for (const base::Rotor& rotor : vehicle_.rotors) {
      if (rotor.tilt) x[servo++] = forward_tilt_rad(rotor);
    }
    model_.limit(x);
    std::array<double, ForceModel::kMaxStates> rates{};
    const auto rate_of = [&](std::size_t state) {
      Wrench ignored;
      model_.evaluate(body, air, x, std::span(rates).first(x.size()), ignored);
      return rates[state];
    };
    for (std::size_t i = 0; i < vehicle_.rotors.size(); ++i) {
      for (int step = 0; step < kMostSteps; ++step) {
        const double here = rate_of(i);
        if (std::abs(here) < kSteady_rad_s2) break;
        x[i] += kStep_rad_s;
        const double slope = (rate_of(i) - here) / kStep_rad_s;
        x[i] -= kStep_rad_s;
        if (slope >= 0) break;  // it runs away, or its limits hold it
        x[i] -= here / slope;
        model_.limit(x);
      }
    }
  }

  const base::Vehicle& vehicle_;
  RotorModel model_;
};

Airframe airframe_of(const base::Vehicle& vehicle, const VehicleModel& model, const AeroModel& aero,
                     PushingRotors* rotors) {
  Airframe airframe;
  airframe.mass_kg = model.mass.mass_kg();
  airframe.inertia_B = model.mass.inertia_B();
  airframe.air.gravity_W = {0, 0, -base::kStandardGravity_m_s2};
  airframe.air.air_density_kg_m3 = base::isa::density_kg_m3(0);
  airframe.air.height_above_ground_m = std::numeric_limits<double>::infinity();
  airframe.surfaces = vehicle.aero->surfaces.size();
  const BodyDrag drag(vehicle.body_drag_linear_n_s_m, vehicle.body_drag);
  airframe.wrench = [&aero, rotors, drag, air = airframe.air](const BodyState& body,
                                                              std::span<const double> deflections,
                                                              double throttle) {
    Wrench wrench;
    std::array<double, base::kMaxOutputs> ignored{};
    aero.evaluate(body, air, deflections, std::span(ignored).first(deflections.size()), wrench);
    drag.evaluate(body, air, {}, {}, wrench);
    if (rotors != nullptr) rotors->add(body, air, throttle, wrench);
    return wrench;
  };
  return airframe;
}

void print_surfaces(std::string& text, const base::AeroParams& aero) {
  if (aero.surfaces.empty()) return;
  add_line(text, "surfaces           deflection at output -1 and +1");
  for (const base::ControlSurface& surface : aero.surfaces) {
    add_line(text, "  {:<16} {:6.1f} {:6.1f} deg  output {}", surface.name,
             base::degrees(surface.min_rad), base::degrees(surface.max_rad), surface.output + 1);
  }
}

void print_trim(std::string& text, const base::AeroParams& aero, const Trim& trim) {
  add_line(text, "trim               level at {:g} m/s, at sea level", aero.cruise_m_s);
  add_line(text, "  {:<16} {:8.3f} deg", "angle of attack", base::degrees(trim.alpha_rad));
  if (trim.beta_rad != 0) {
    add_line(text, "  {:<16} {:8.3f} deg", "sideslip", base::degrees(trim.beta_rad));
  }
  add_line(text, "  {:<16} {:8.4f}", "throttle", trim.throttle);
  for (std::size_t i = 0; i < aero.surfaces.size(); ++i) {
    const base::ControlSurface& surface = aero.surfaces[i];
    const double angle = trim.deflections_rad[i];
    const auto [low, high] = std::minmax(surface.min_rad, surface.max_rad);
    add_line(text, "  {:<16} {:8.3f} deg  {:8.5f} rad{}", surface.name, base::degrees(angle), angle,
             angle < low || angle > high ? ", beyond its limits" : "");
  }
}

void print_modes(std::string& text, const std::vector<FlightMode>& modes) {
  add_line(text, "modes              throttle and surfaces held");
  for (const FlightMode& mode : modes) {
    const double real = mode.eigenvalue.real();
    if (mode.oscillates()) {
      add_line(text, "  {:<16} {:8.4f} +- {:.4f}i 1/s  {:.3f} rad/s, damping {:.3f}", mode.name,
               real, mode.eigenvalue.imag(), mode.frequency_rad_s(), mode.damping());
    } else {
      add_line(text, "  {:<16} {:8.4f} 1/s  {} in {:.2f} s", mode.name, real,
               real < 0 ? "halves" : "doubles", std::log(2) / std::abs(real));
    }
  }
}

/// Whether the wing's chord lies along the body's nose, as glide and trim assume; that of a
/// tailsitter stands upright in hover.
bool flies_nose_first(const base::AeroParams& aero) {
  constexpr double kForwards = 0.5;  // of a chord
  return aero.derivatives || std::ranges::any_of(aero.panels, [](const base::PanelParams& panel) {
           return panel.forward_B.x() > kForwards;
         });
}

}  // namespace

std::string describe_wings(const base::Vehicle& vehicle, const VehicleModel& model) {
  const base::AeroParams& params = *vehicle.aero;
  std::string text;
  print_surfaces(text, params);
  if (!flies_nose_first(params)) {
    add_line(text, "trim               none: no panel's chord points along the nose of hover");
    return text;
  }

  const AeroModel aero(params);
  PushingRotors rotors(vehicle);
  std::vector<std::pair<double, double>> limits;
  for (const base::ControlSurface& surface : params.surfaces) {
    limits.push_back(std::minmax({surface.min_rad, surface.max_rad}));
  }
  const Airframe gliding = airframe_of(vehicle, model, aero, nullptr);
  if (const auto polar = glide_polar(gliding, params.cruise_m_s, limits)) {
    add_line(text, "stall              {:.2f} m/s at an angle of attack of {:.1f} deg",
             polar->stall_speed_m_s, base::degrees(polar->stall_alpha_rad));
    add_line(text, "best glide         {:.2f} m ahead for each m of height, at {:.2f} m/s",
             polar->best_glide_ratio, polar->best_glide_m_s);
  } else {
    add_line(text, "stall              no surface balances its pitching moment");
  }

  const Airframe flying = airframe_of(vehicle, model, aero, &rotors);
  const auto trim = level_trim(flying, params.cruise_m_s);
  if (!trim) {
    add_line(text,
             "trim               none: at {:g} m/s thrust, lift and surfaces do not hold it level",
             params.cruise_m_s);
    return text;
  }
  print_trim(text, params, *trim);
  print_modes(text, flight_modes(flying, *trim));
  return text;
}

}  // namespace cas::sim
