// SPDX-License-Identifier: BSD-3-Clause
#include "plugins/gps/gps_model.hpp"

#include <algorithm>

#include "plugins/common/gauss_markov.hpp"
#include "plugins/common/noise_params.hpp"

namespace cas::sim {
namespace {

constexpr std::uint8_t kNoFix = 1;          // GPS_FIX_TYPE_NO_FIX
constexpr std::uint8_t kFix3d = 3;          // GPS_FIX_TYPE_3D_FIX
constexpr double kAccuracyWithoutFix = 99;  // m, reported by receivers during search

base::SimTime moment(double seconds) { return base::SimTime(base::from_seconds(seconds)); }

base::LocalProjection choose_projection(const base::GpsSheet& sheet,
                                        const base::LocalProjection& world) {
  if (!sheet.earth_model) return world;
  return base::LocalProjection(world.home(), *sheet.earth_model);
}

}  // namespace

GpsModel::GpsModel(const base::GpsSheet& sheet, const base::LocalProjection& projection,
                   std::uint64_t seed)
    : sheet_(sheet),
      position_stddev_m_(white_noise(sheet.position, 1.0, sheet.rate_hz)),
      velocity_stddev_m_s_(white_noise(sheet.velocity, 1.0, sheet.rate_hz)),
      projection_(choose_projection(sheet, projection)),
      random_(seed),
      drift_(drift_of(sheet.position_drift, 1.0), 1.0 / sheet.rate_hz) {
  drift_.settle(random_);
}

GpsSample GpsModel::sample(base::SimTime time, const Eigen::Vector3d& p_N,
                           const Eigen::Vector3d& v_N) {
  const Eigen::Vector3d error_N =
      drift_.advance(random_) + position_stddev_m_.cwiseProduct(normal3(random_));
  const Eigen::Vector3d velocity_error_N = velocity_stddev_m_s_.cwiseProduct(normal3(random_));
  GpsSample sample;
  sample.time = time;
  if (!has_fix(time)) {
    sample.fix_type = kNoFix;
    sample.satellites = 0;
    sample.eph_m = sample.epv_m = kAccuracyWithoutFix;
    return sample;
  }
  sample.fix_type = kFix3d;
  sample.satellites = static_cast<std::uint8_t>(sheet_.satellites);
  sample.position = projection_.to_geodetic(p_N + error_N);
  sample.velocity_N = v_N + velocity_error_N;
  sample.eph_m = sheet_.eph_m;
  sample.epv_m = sheet_.epv_m;
  return sample;
}

bool GpsModel::has_fix(base::SimTime time) const {
  if (time < moment(sheet_.first_fix_s)) return false;
  return std::none_of(sheet_.fix_losses.begin(), sheet_.fix_losses.end(),
                      [time](const base::GpsSheet::FixLoss& loss) {
                        return time >= moment(loss.from_s) && time < moment(loss.to_s);
                      });
}

}  // namespace cas::sim
