// SPDX-License-Identifier: BSD-3-Clause
#include "plugins/magnetometer/magnetometer_model.hpp"

#include "base/earth/frames.hpp"
#include "base/earth/magnetic_field.hpp"
#include "plugins/common/gauss_markov.hpp"
#include "plugins/common/noise_params.hpp"

namespace cas::sim {
namespace {

constexpr double kReevaluateAfter = 1000.0;  // m

Eigen::Matrix3d parse_soft_iron(const base::ConfigNode& node) {
  const auto rows = node.as<std::vector<double>>();
  if (rows.size() != 9) node.fail("must list the 9 numbers of a 3x3 matrix, row by row");
  return Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(rows.data());
}

}  // namespace

MagnetometerParams parse_magnetometer_params(const base::ConfigNode& node, double step_s) {
  MagnetometerParams params;
  params.rate_hz = parse_rate(node, step_s);
  params.stddev_gauss = parse_white_noise(node, {"", "gauss", 1.0}, params.rate_hz);
  params.bias_walk = parse_drift(node, {"", "gauss", 1.0});
  params.hard_iron_gauss = get_axes(node, "hard_iron_gauss");
  if (const auto matrix = node.find("soft_iron")) params.soft_iron = parse_soft_iron(*matrix);
  params.lsb_gauss = node.get_in("lsb_gauss", 0.0, 0.0, 1.0);
  return params;
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
