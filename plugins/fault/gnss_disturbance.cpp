// SPDX-License-Identifier: BSD-3-Clause
#include "plugins/fault/gnss_disturbance.hpp"

#include <cmath>

#include "base/earth/geodesy.hpp"
#include "plugins/common/gauss_markov.hpp"
#include "plugins/common/satellite_signals.hpp"

namespace cas::sim {

GpsSample jammed_sample(GpsSample sample, double loss_db, const base::LocalProjection& projection,
                        base::NormalRandom& random) {
  constexpr int kLeastSatellites = 4;
  constexpr std::uint8_t kNoFix = 1;          // GPS_FIX_TYPE_NO_FIX
  constexpr std::uint8_t kFix2d = 2;          // GPS_FIX_TYPE_2D_FIX
  constexpr double kAccuracyWithoutFix = 99;  // m, reported by receivers during search
  const int before = sample.satellites;
  sample.cn0_db_hz -= loss_db;
  int used = 0;
  while (used < before && satellite_cn0_db_hz(sample.cn0_db_hz, used, before) >= kLeastCn0_db_hz) {
    ++used;
  }
  sample.satellites = static_cast<std::uint8_t>(used);
  if (sample.fix_type < kFix2d) return sample;
  if (used < kLeastSatellites) {
    sample.fix_type = kNoFix;
    sample.eph_m = sample.epv_m = kAccuracyWithoutFix;
    return sample;
  }
  const double variance_factor = std::pow(10, loss_db / 10) * before / used;
  // Half of the horizontal variance is that of each axis.
  const double added = std::sqrt(variance_factor - 1);
  const double horizontal_m = added * sample.eph_m / std::sqrt(2.0);
  const Eigen::Vector3d deviation_m(horizontal_m, horizontal_m, added * sample.epv_m);
  sample.position = projection.to_geodetic(projection.to_local(sample.position) +
                                           deviation_m.cwiseProduct(normal3(random)));
  sample.eph_m *= std::sqrt(variance_factor);
  sample.epv_m *= std::sqrt(variance_factor);
  return sample;
}

Eigen::Vector3d CorrelatedError::at(base::SimTime time, const Eigen::Vector3d& stddev,
                                    double time_constant_s, base::NormalRandom& random) {
  const double kept = at_ ? std::exp(-base::to_seconds(time - *at_) / time_constant_s) : 0.0;
  value_ = kept * value_ + std::sqrt(1 - kept * kept) * stddev.cwiseProduct(normal3(random));
  at_ = time;
  return value_;
}

}  // namespace cas::sim
