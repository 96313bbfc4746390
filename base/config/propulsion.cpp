// SPDX-License-Identifier: BSD-3-Clause
#include "base/config/propulsion.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "base/error.hpp"

namespace cas::base {
namespace {

/// Slope at a point between two straight pieces: the weighted harmonic mean, or 0 at a peak.
double inner_slope(double left_width, double left, double right_width, double right) {
  if (left * right <= 0) return 0;
  const double a = 2 * right_width + left_width;
  const double b = right_width + 2 * left_width;
  return (a + b) / (a / left + b / right);
}

/// Slope at an end: that of the parabola through three points, held so that the curve stays
/// monotone.
double end_slope(double width, double own, double next_width, double next) {
  const double slope = ((2 * width + next_width) * own - width * next) / (width + next_width);
  if (slope * own <= 0) return 0;
  if (own * next <= 0 && std::abs(slope) > 3 * std::abs(own)) return 3 * own;
  return slope;
}

}  // namespace

PropellerCurve PropellerCurve::polynomial(double c0, double c1, double c2) {
  PropellerCurve curve;
  curve.nodes_ = {{0, c0, c1}};
  curve.square_ = c2;
  curve.settle_ends();
  return curve;
}

PropellerCurve PropellerCurve::table(std::span<const double> ratios,
                                     std::span<const double> values) {
  CAS_CHECK(!ratios.empty() && ratios.size() == values.size());
  PropellerCurve curve;
  curve.nodes_.clear();
  for (std::size_t i = 0; i < ratios.size(); ++i) {
    curve.nodes_.push_back({ratios[i], values[i], 0});
  }
  std::vector<Node>& nodes = curve.nodes_;
  const std::size_t pieces = nodes.size() - 1;
  const auto width = [&](std::size_t i) { return nodes[i + 1].ratio - nodes[i].ratio; };
  const auto rise = [&](std::size_t i) { return (nodes[i + 1].value - nodes[i].value) / width(i); };
  for (std::size_t i = 1; i < pieces; ++i) {
    nodes[i].slope = inner_slope(width(i - 1), rise(i - 1), width(i), rise(i));
  }
  if (pieces == 1) {
    nodes.front().slope = nodes.back().slope = rise(0);
  } else if (pieces > 1) {
    nodes.front().slope = end_slope(width(0), rise(0), width(1), rise(1));
    nodes.back().slope =
        end_slope(width(pieces - 1), rise(pieces - 1), width(pieces - 2), rise(pieces - 2));
  }
  curve.settle_ends();
  return curve;
}

void PropellerCurve::settle_ends() {
  constexpr double kFade = 0.2;        // of J
  constexpr double kMostChange = 0.5;  // of the value that fades
  if (nodes_.front().ratio > 0) {
    const Node first = nodes_.front();
    nodes_.insert(nodes_.begin(), {0, first.value - first.slope * first.ratio, first.slope});
  }
  const Node& first = nodes_.front();
  const double most = kMostChange * std::abs(first.value);
  fade_ = std::abs(first.slope) * kFade > most ? most / std::abs(first.slope) : kFade;
  at_rest_ = scaled(1, 0);
}

double PropellerCurve::scaled(double n, double u) const {
  const Node& last = nodes_.back();
  const double beyond = u - n * last.ratio;
  if (beyond >= 0) return n * (n * last.value + last.slope * beyond) + square_ * beyond * beyond;
  if (n <= 0) return 0;

  const Node& first = nodes_.front();
  const double behind = u - n * first.ratio;
  if (behind <= 0) {
    if (fade_ <= 0) return n * n * first.value;
    return n * n * (first.value + first.slope * fade_ * behind / (fade_ * n - behind));
  }

  // Hermite's cubic between two rows.
  const double ratio = u / n;
  const auto above = std::upper_bound(nodes_.begin() + 1, nodes_.end() - 1, ratio,
                                      [](double j, const Node& node) { return j < node.ratio; });
  const Node& b = *above;
  const Node& a = *(above - 1);
  const double width = b.ratio - a.ratio;
  const double t = (ratio - a.ratio) / width;
  const double rise = b.value - a.value;
  const double bend = (1 - t) * (width * a.slope - rise) - t * (width * b.slope - rise);
  return n * n * (a.value + t * (rise + (1 - t) * bend));
}

double Propeller::thrust_n(double density_kg_m3, double omega_rad_s, double axial_m_s) const {
  const double sense = omega_rad_s < 0 ? -1 : 1;
  const double d2 = diameter_m * diameter_m;
  const double n = std::abs(omega_rad_s) / (2 * M_PI);
  return sense * density_kg_m3 * d2 * d2 * thrust.scaled(n, sense * axial_m_s / diameter_m);
}

double Propeller::torque_nm(double density_kg_m3, double omega_rad_s, double axial_m_s) const {
  const double sense = omega_rad_s < 0 ? -1 : 1;
  const double d2 = diameter_m * diameter_m;
  const double n = std::abs(omega_rad_s) / (2 * M_PI);
  return sense * density_kg_m3 * d2 * d2 * diameter_m *
         torque.scaled(n, sense * axial_m_s / diameter_m);
}

double ElectricMotor::current_a(double voltage_v, double omega_rad_s) const {
  return std::clamp((voltage_v - torque_constant_nm_a * omega_rad_s) / resistance_ohm,
                    -max_current_a, max_current_a);
}

double ElectricMotor::torque_nm(double current, double omega_rad_s) const {
  constexpr double kStanding_rad_s = 1;
  const double x = std::clamp(omega_rad_s / kStanding_rad_s, -1.0, 1.0);
  const double friction = 0.5 * x * (3 - x * x);
  return torque_constant_nm_a * (current - friction * no_load_current_a);
}

double ElectricMotor::steady_speed_rad_s(double duty, double torque_coefficient) const {
  // k_m w^2 + (K^2 / R) w = K (d V / R - i_0), in the form that allows k_m = 0
  const double k = torque_constant_nm_a;
  const double drive = k * (std::abs(duty) * supply_v / resistance_ohm - no_load_current_a);
  if (drive <= 0) return 0;
  const double brake = k * k / resistance_ohm;
  double speed = 2 * drive / (brake + std::sqrt(brake * brake + 4 * torque_coefficient * drive));
  const double most = k * (max_current_a - no_load_current_a);  // torque at the limit
  if (torque_coefficient * speed * speed > most) {
    speed = std::sqrt(std::max(0.0, most) / torque_coefficient);
  }
  return std::copysign(speed, duty);
}

double ElectricMotor::steady_duty(double omega_rad_s, double torque_coefficient) const {
  const double speed = std::abs(omega_rad_s);
  if (speed == 0) return 0;
  const double k = torque_constant_nm_a;
  const double current = torque_coefficient * speed * speed / k + no_load_current_a;
  const double duty = (resistance_ohm * current + k * speed) / supply_v;
  return std::copysign(std::min(1.0, duty), omega_rad_s);
}

double ElectricMotor::lag_s(double inertia_kg_m2, double torque_coefficient,
                            double omega_rad_s) const {
  const double brake = torque_constant_nm_a * torque_constant_nm_a / resistance_ohm;
  return inertia_kg_m2 / (brake + 2 * torque_coefficient * std::abs(omega_rad_s));
}

double ElectricMotor::rounded(double duty) const {
  return esc_steps > 0 ? std::round(duty * esc_steps) / esc_steps : duty;
}

double BatteryParams::open_v(double charge) const {
  if (curve.empty()) return empty_v + charge * (full_v - empty_v);
  const auto above =
      std::upper_bound(curve.begin() + 1, curve.end() - 1, charge,
                       [](double share, const Point& point) { return share < point.charge; });
  const Point& b = *above;
  const Point& a = *(above - 1);
  return a.voltage_v + (charge - a.charge) / (b.charge - a.charge) * (b.voltage_v - a.voltage_v);
}

}  // namespace cas::base
