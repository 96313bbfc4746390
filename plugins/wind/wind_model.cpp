// SPDX-License-Identifier: BSD-3-Clause
#include "plugins/wind/wind_model.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include "base/angles.hpp"

namespace cas::sim {
namespace {

constexpr double kSlowestSweep = 1.0;  // m/s: else the field would not move in a hover in still air

WindLaw parse_law(const base::ConfigNode& node) {
  const auto word = node.as<std::string>();
  if (word == "uniform") return WindLaw::kUniform;
  if (word == "log") return WindLaw::kLog;
  if (word == "power") return WindLaw::kPower;
  node.fail("must be uniform, log or power");
}

/// A word, or a law with its figures.
WindProfile parse_profile(const base::ConfigNode& node) {
  WindProfile profile;
  if (node.is_scalar()) {
    profile.law = parse_law(node);
    return profile;
  }
  profile.law = parse_law(node.at("law"));
  profile.reference_m = node.get_in("reference_m", profile.reference_m, 0.1, 1000);
  if (profile.law == WindLaw::kLog) {
    // Below half of the reference, so that the logarithm of their ratio is not near 0.
    profile.roughness_m =
        node.get_in("roughness_m", profile.roughness_m, 1e-5, 0.5 * profile.reference_m);
  }
  if (profile.law == WindLaw::kPower) {
    profile.exponent = node.get_in("exponent", profile.exponent, 0, 1);
  }
  return profile;
}

/// A number of metres per second at 20 ft, or a word of MIL-F-8785C.
double parse_turbulence(const base::ConfigNode& node) {
  const auto word = node.as<std::string>();
  if (word == "none") return 0;
  if (word == "light") return 15 * kMetresPerSecondPerKnot;
  if (word == "moderate") return 30 * kMetresPerSecondPerKnot;
  if (word == "severe") return 45 * kMetresPerSecondPerKnot;
  const double w20_m_s = node.as<double>();
  if (w20_m_s < 0) node.fail("must be none, light, moderate, severe or a wind at 20 ft in m/s");
  return w20_m_s;
}

WindParams::Gust parse_gust(const base::ConfigNode& node) {
  WindParams::Gust gust;
  gust.start = base::SimTime(base::from_seconds(node.require_in("start_s", 0, 1e6)));
  gust.gust.amplitude_N_m_s = node.require<Eigen::Vector3d>("amplitude_m_s");
  gust.gust.length_m = node.require_in("length_m", 0.1, 1e5);
  gust.gust.hold_s = node.get_in("hold_s", 0, 0, 1e6);
  return gust;
}

}  // namespace

double WindProfile::share_at(double height_m) const {
  switch (law) {
    case WindLaw::kUniform:
      return 1;
    case WindLaw::kLog:
      return std::log(std::max(height_m, roughness_m) / roughness_m) /
             std::log(reference_m / roughness_m);
    case WindLaw::kPower:
      return std::pow(std::max(height_m, 0.0) / reference_m, exponent);
  }
  return 1;
}

WindParams parse_wind_params(const base::ConfigNode& node) {
  WindParams params;
  const double speed = node.get_in("mean_m_s", 0, 0, 100);
  const double from_deg =
      speed > 0 ? node.require_in("from_deg", 0, 360) : node.get("from_deg", 0.0);
  const double from = base::radians(from_deg);
  params.mean_N_m_s = {-speed * std::cos(from), -speed * std::sin(from), 0};
  if (const auto profile = node.find("profile")) params.profile = parse_profile(*profile);
  if (const auto word = node.find("turbulence"))
    params.turbulence_w20_m_s = parse_turbulence(*word);
  if (node.has("span_m")) params.span_m = node.require_in("span_m", 0.05, 100);
  if (const auto gusts = node.find("gusts")) {
    for (const base::ConfigNode& gust : gusts->items()) params.gusts.push_back(parse_gust(gust));
  }
  std::stable_sort(params.gusts.begin(), params.gusts.end(),
                   [](const auto& a, const auto& b) { return a.start < b.start; });
  return params;
}

Eigen::Vector3d GustModel::advance_N(double speed_m_s, double dt) {
  const double length = gust_.length_m;
  const double share = 0.5 * (1.0 - std::cos(M_PI * std::min(distance_m_, length) / length));
  const Eigen::Vector3d wind_N = gust_.amplitude_N_m_s * (falling_ ? 1.0 - share : share);
  if (distance_m_ < length) {
    distance_m_ += speed_m_s * dt;
  } else if (falling_) {
    over_ = true;
  } else if (held_s_ < gust_.hold_s) {
    held_s_ += dt;
  } else {
    falling_ = true;
    distance_m_ = 0;
  }
  return wind_N;
}

WindModel::WindModel(const WindParams& params, std::uint64_t seed)
    : params_(params), dryden_(seed), rates_(params.span_m, base::derive_seed(seed, "span")) {}

bool WindModel::start(const GustCommand& gust) {
  const auto free = std::find_if(gusts_.begin(), gusts_.end(),
                                 [](const GustModel& other) { return other.over(); });
  if (free == gusts_.end()) return false;
  *free = GustModel(gust);
  return true;
}

Eigen::Vector3d WindModel::advance_N(base::SimTime now, double dt, double height_m,
                                     const Eigen::Vector3d& v_N, const Eigen::Vector3d& field_N) {
  Eigen::Vector3d wind_N = field_N + params_.mean_N_m_s * params_.profile.share_at(height_m);
  gradient_N_.setZero();
  if (params_.span_m > 0) {
    const double half = 0.5 * params_.span_m;
    const double rise =
        params_.profile.share_at(height_m + half) - params_.profile.share_at(height_m - half);
    gradient_N_.col(2) = -rise / params_.span_m * params_.mean_N_m_s;  // N points down
  }
  const double sweep = std::max((v_N - wind_N).norm(), kSlowestSweep);
  // A profile does not turn the mean wind, whose direction holds on the ground, too.
  const Eigen::Vector3d along_N = field_N.isZero(0) ? params_.mean_N_m_s : wind_N;
  wind_N += turbulence_N(height_m, sweep, dt, along_N);
  for (; next_gust_ < params_.gusts.size() && params_.gusts[next_gust_].start <= now;
       ++next_gust_) {
    start(params_.gusts[next_gust_].gust);
  }
  for (GustModel& gust : gusts_) {
    if (!gust.over()) wind_N += gust.advance_N(sweep, dt);
  }
  return wind_N;
}

Eigen::Vector3d WindModel::turbulence_N(double height_m, double speed_m_s, double dt,
                                        const Eigen::Vector3d& along_N) {
  if (params_.turbulence_w20_m_s <= 0) return Eigen::Vector3d::Zero();
  const DrydenScales scales = DrydenScales::at(params_.turbulence_w20_m_s, height_m);
  const Eigen::Vector3d uvw = dryden_.advance(scales, speed_m_s, dt);
  // u along the wind (north in still air), v to its right, w up.
  const double direction = std::atan2(along_N.y(), along_N.x());
  const double c = std::cos(direction);
  const double s = std::sin(direction);
  if (params_.span_m > 0) {
    Eigen::Matrix3d axes;  // of u, v, w in N
    axes << c, -s, 0, s, c, 0, 0, 0, -1;
    gradient_N_ += axes * rates_.advance(scales, speed_m_s, dt, uvw) * axes.transpose();
  }
  return {c * uvw[0] - s * uvw[1], s * uvw[0] + c * uvw[1], -uvw[2]};
}

}  // namespace cas::sim
