// SPDX-License-Identifier: BSD-3-Clause
#include "plugins/aero/flight_modes.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>

namespace cas::sim {
namespace {

/// Eigenvalues of four rows and columns of the linearised motion, fastest first, one of each pair.
std::vector<std::complex<double>> eigenvalues(const Airframe& airframe, const Trim& trim,
                                              const std::array<Eigen::Index, 4>& states) {
  constexpr double kDifference = 1e-6;  // m/s, rad/s, rad
  const FlightState at = state_of(trim);
  Eigen::Matrix4d matrix;
  for (std::size_t j = 0; j < states.size(); ++j) {
    FlightState up = at;
    FlightState down = at;
    up[states[j]] += kDifference;
    down[states[j]] -= kDifference;
    const FlightState slope = (state_rates(airframe, up, trim.deflections_rad, trim.throttle) -
                               state_rates(airframe, down, trim.deflections_rad, trim.throttle)) /
                              (2 * kDifference);
    for (std::size_t i = 0; i < states.size(); ++i) {
      matrix(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j)) = slope[states[i]];
    }
  }
  const Eigen::Vector4cd all = Eigen::EigenSolver<Eigen::Matrix4d>(matrix).eigenvalues();
  std::vector<std::complex<double>> result;
  for (const std::complex<double>& each : all) {
    if (each.imag() >= 0) result.push_back(each);
  }
  std::ranges::sort(result, std::greater{}, [](const auto& z) { return std::abs(z); });
  return result;
}

void add_pitch_modes(const Airframe& airframe, const Trim& trim, std::vector<FlightMode>& modes) {
  const auto found = eigenvalues(airframe, trim, {0, 2, 4, 7});
  const bool usual = found.size() == 2;
  for (std::size_t i = 0; i < found.size(); ++i) {
    modes.push_back({usual ? (i == 0 ? "short period" : "phugoid") : "pitch mode", found[i]});
  }
}

void add_lateral_modes(const Airframe& airframe, const Trim& trim, std::vector<FlightMode>& modes) {
  const auto found = eigenvalues(airframe, trim, {1, 3, 5, 6});
  const bool usual = found.size() == 3;  // a pair and two single ones, the faster of which is roll
  bool has_roll = false;
  for (const std::complex<double>& each : found) {
    std::string name = "lateral mode";
    if (usual && each.imag() > 0) {
      name = "Dutch roll";
    } else if (usual) {
      name = has_roll ? "spiral" : "roll";
      has_roll = true;
    }
    modes.push_back({name, each});
  }
}

}  // namespace

std::vector<FlightMode> flight_modes(const Airframe& airframe, const Trim& trim) {
  std::vector<FlightMode> modes;
  add_pitch_modes(airframe, trim, modes);
  add_lateral_modes(airframe, trim, modes);
  return modes;
}

}  // namespace cas::sim
