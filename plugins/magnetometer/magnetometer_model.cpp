// SPDX-License-Identifier: BSD-3-Clause
#include "plugins/magnetometer/magnetometer_model.hpp"

#include "base/earth/frames.hpp"
#include "base/earth/magnetic_field.hpp"
#include "plugins/common/gauss_markov.hpp"
#include "plugins/common/noise_params.hpp"

namespace cas::sim {
namespace {

constexpr double kReevaluateAfter = 1000.0;  // m

}  // namespace

MagnetometerModel::MagnetometerModel(const base::MagnetometerSheet& sheet,
                                     const base::LocalProjection& projection, double decimal_year,
                                     std::uint64_t seed)
    : sheet_(sheet),
      stddev_gauss_(white_noise(sheet.noise, 1.0, sheet.rate_hz)),
      projection_(projection),
      decimal_year_(decimal_year),
      random_(seed),
      walk_(drift_of(sheet.drift, 1.0), 1.0 / sheet.rate_hz),
      field_W_(base::swap_WN(base::magnetic_field_N(projection.home(), decimal_year))) {}

MagnetometerSample MagnetometerModel::sample(base::SimTime time, const BodyState& state,
                                             const std::optional<Eigen::Vector3d>& own_field_W) {
  if (!own_field_W) follow(state.p_WB);
  const Eigen::Vector3d field_B = state.q_WB.conjugate() * own_field_W.value_or(field_W_);
  Eigen::Vector3d reading = sheet_.soft_iron * field_B + sheet_.hard_iron_gauss +
                            walk_.advance(random_) + stddev_gauss_.cwiseProduct(normal3(random_));
  if (sheet_.lsb_gauss > 0) {
    reading = (reading / sheet_.lsb_gauss).array().round().matrix() * sheet_.lsb_gauss;
  }
  return {time, reading};
}

void MagnetometerModel::follow(const Eigen::Vector3d& p_W) {
  if ((p_W - evaluated_at_W_).squaredNorm() < kReevaluateAfter * kReevaluateAfter) return;
  const base::Geodetic place = projection_.to_geodetic(base::swap_WN(p_W));
  field_W_ = base::swap_WN(base::magnetic_field_N(place, decimal_year_));
  evaluated_at_W_ = p_W;
}

}  // namespace cas::sim
