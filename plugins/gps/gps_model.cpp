// SPDX-License-Identifier: BSD-3-Clause
#include "plugins/gps/gps_model.hpp"

#include <algorithm>

#include "base/config/config_whole.hpp"
#include "plugins/common/gauss_markov.hpp"
#include "plugins/common/noise_params.hpp"

namespace cas::sim {
namespace {

constexpr std::uint8_t kNoFix = 1;          // GPS_FIX_TYPE_NO_FIX
constexpr std::uint8_t kFix3d = 3;          // GPS_FIX_TYPE_3D_FIX
constexpr double kAccuracyWithoutFix = 99;  // m, what receivers claim while they search
constexpr double kMostSeconds = 1e6;

base::SimTime moment(double seconds) { return base::SimTime(base::from_seconds(seconds)); }

std::vector<FixLoss> parse_fix_losses(const base::ConfigNode& node) {
  std::vector<FixLoss> losses;
  for (const base::ConfigNode& item : node.items()) {
    const double from_s = item.require_in("from_s", 0.0, kMostSeconds);
    losses.push_back({moment(from_s), moment(item.require_in("to_s", from_s, kMostSeconds))});
  }
  return losses;
}

std::optional<base::EarthModel> parse_earth_model(const base::ConfigNode& node) {
  const auto child = node.find("earth_model");
  if (!child) return std::nullopt;
  const auto word = child->as<std::string>();
  if (word == "sphere") return base::EarthModel::kSphere;
  if (word == "wgs84") return base::EarthModel::kWgs84;
  child->fail("must be sphere or wgs84");
}

base::LocalProjection choose_projection(const GpsParams& params,
                                        const base::LocalProjection& world) {
  if (!params.earth_model) return world;
  return base::LocalProjection(world.home(), *params.earth_model);
}

}  // namespace

GpsParams parse_gps_params(const base::ConfigNode& node, double step_s) {
  constexpr double kMostDelay = 10.0;
  constexpr double kMostMetres = 600.0;  // the wire's 16 bits of centimetres
  GpsParams params;
  params.rate_hz = parse_rate(node, step_s);
  params.delay = base::from_seconds(node.get_in("delay_s", 0.0, 0.0, kMostDelay));
  params.position_stddev_m = parse_white_noise(node, {"position_", "m", 1.0}, params.rate_hz);
  params.position_drift = parse_drift(node, {"position_", "m", 1.0});
  params.velocity_stddev_m_s = parse_white_noise(node, {"velocity_", "m_s", 1.0}, params.rate_hz);
  params.antenna_B_m = get_axes(node, "antenna_B_m");
  params.eph_m = node.require_in("eph_m", 0.0, kMostMetres);
  params.epv_m = node.require_in("epv_m", 0.0, kMostMetres);
  params.satellites = base::require_whole_in<std::uint8_t>(node, "satellites", 0, 64);
  params.first_fix = moment(node.get_in("first_fix_s", 0.0, 0.0, kMostSeconds));
  if (const auto losses = node.find("fix_losses")) params.fix_losses = parse_fix_losses(*losses);
  params.earth_model = parse_earth_model(node);
  return params;
}

GpsModel::GpsModel(const GpsParams& params, const base::LocalProjection& projection,
                   std::uint64_t seed)
    : params_(params),
      projection_(choose_projection(params, projection)),
      random_(seed),
      drift_(params.position_drift, 1.0 / params.rate_hz) {
  drift_.settle(random_);
}

GpsSample GpsModel::sample(base::SimTime time, const Eigen::Vector3d& p_N,
                           const Eigen::Vector3d& v_N) {
  const Eigen::Vector3d error_N =
      drift_.advance(random_) + params_.position_stddev_m.cwiseProduct(normal3(random_));
  const Eigen::Vector3d velocity_error_N =
      params_.velocity_stddev_m_s.cwiseProduct(normal3(random_));
  GpsSample sample;
  sample.time = time;
  if (!has_fix(time)) {
    sample.fix_type = kNoFix;
    sample.satellites = 0;
    sample.eph_m = sample.epv_m = kAccuracyWithoutFix;
    return sample;
  }
  sample.fix_type = kFix3d;
  sample.satellites = params_.satellites;
  sample.position = projection_.to_geodetic(p_N + error_N);
  sample.velocity_N = v_N + velocity_error_N;
  sample.eph_m = params_.eph_m;
  sample.epv_m = params_.epv_m;
  return sample;
}

bool GpsModel::has_fix(base::SimTime time) const {
  if (time < params_.first_fix) return false;
  return std::none_of(params_.fix_losses.begin(), params_.fix_losses.end(),
                      [time](const FixLoss& loss) { return time >= loss.from && time < loss.to; });
}

}  // namespace cas::sim
