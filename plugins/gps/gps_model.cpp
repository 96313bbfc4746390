// SPDX-License-Identifier: BSD-3-Clause
#include "plugins/gps/gps_model.hpp"

#include <algorithm>

#include "base/config/sensor_sheets.hpp"
#include "plugins/common/gauss_markov.hpp"
#include "plugins/common/noise_params.hpp"

namespace cas::sim {
namespace {

constexpr std::uint8_t kNoFix = 1;          // GPS_FIX_TYPE_NO_FIX
constexpr std::uint8_t kFix3d = 3;          // GPS_FIX_TYPE_3D_FIX
constexpr double kAccuracyWithoutFix = 99;  // m, reported by receivers during search

base::SimTime moment(double seconds) { return base::SimTime(base::from_seconds(seconds)); }

base::LocalProjection choose_projection(const GpsParams& params,
                                        const base::LocalProjection& world) {
  if (!params.earth_model) return world;
  return base::LocalProjection(world.home(), *params.earth_model);
}

}  // namespace

GpsParams parse_gps_params(const base::ConfigNode& node, double step_s) {
  const base::GpsSheet sheet = base::read_gps_sheet(node);
  check_rate(node, sheet.rate_hz, step_s);
  GpsParams params;
  params.rate_hz = sheet.rate_hz;
  params.delay = base::from_seconds(sheet.delay_s);
  params.position_stddev_m = white_noise(sheet.position, 1.0, sheet.rate_hz);
  params.position_drift = drift_of(sheet.position_drift, 1.0);
  params.velocity_stddev_m_s = white_noise(sheet.velocity, 1.0, sheet.rate_hz);
  params.antenna_B_m = sheet.antenna_B_m;
  params.eph_m = sheet.eph_m;
  params.epv_m = sheet.epv_m;
  params.satellites = static_cast<std::uint8_t>(sheet.satellites);
  params.first_fix = moment(sheet.first_fix_s);
  for (const auto& loss : sheet.fix_losses) {
    params.fix_losses.push_back({moment(loss.from_s), moment(loss.to_s)});
  }
  params.earth_model = sheet.earth_model;
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
