// SPDX-License-Identifier: BSD-3-Clause
#include "plugins/magnetometer/magnetometer_model.hpp"

#include "base/config/sensor_sheets.hpp"
#include "base/earth/frames.hpp"
#include "base/earth/magnetic_field.hpp"
#include "plugins/common/gauss_markov.hpp"
#include "plugins/common/noise_params.hpp"

namespace cas::sim {
namespace {

constexpr double kReevaluateAfter = 1000.0;  // m

}  // namespace

MagnetometerParams parse_magnetometer_params(const base::ConfigNode& node, double step_s) {
  const base::MagnetometerSheet sheet = base::read_magnetometer_sheet(node);
  check_rate(node, sheet.rate_hz, step_s);
  return {.rate_hz = sheet.rate_hz,
          .stddev_gauss = white_noise(sheet.noise, 1.0, sheet.rate_hz),
          .bias_walk = drift_of(sheet.drift, 1.0),
          .hard_iron_gauss = sheet.hard_iron_gauss,
          .soft_iron = sheet.soft_iron,
          .lsb_gauss = sheet.lsb_gauss};
}

MagnetometerModel::MagnetometerModel(const MagnetometerParams& params,
                                     const base::LocalProjection& projection, double decimal_year,
                                     std::uint64_t seed)
    : params_(params),
      projection_(projection),
      decimal_year_(decimal_year),
      random_(seed),
      walk_(params.bias_walk, 1.0 / params.rate_hz),
      field_W_(base::swap_WN(base::magnetic_field_N(projection.home(), decimal_year))) {}

MagnetometerSample MagnetometerModel::sample(base::SimTime time, const BodyState& state,
                                             const std::optional<Eigen::Vector3d>& own_field_W) {
  if (!own_field_W) follow(state.p_WB);
  const Eigen::Vector3d field_B = state.q_WB.conjugate() * own_field_W.value_or(field_W_);
  Eigen::Vector3d reading = params_.soft_iron * field_B + params_.hard_iron_gauss +
                            walk_.advance(random_) +
                            params_.stddev_gauss.cwiseProduct(normal3(random_));
  if (params_.lsb_gauss > 0) {
    reading = (reading / params_.lsb_gauss).array().round().matrix() * params_.lsb_gauss;
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
