// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>

#include "base/config/sensor_sheets.hpp"
#include "base/earth/geodesy.hpp"
#include "base/random.hpp"
#include "base/time/clock.hpp"
#include "libsim/api/messages.hpp"
#include "libsim/api/world.hpp"
#include "plugins/common/gauss_markov.hpp"

namespace cas::sim {

/// Earth's field (World Magnetic Model) or the world's own in the axes of B, bent by soft iron,
/// shifted by hard iron.
///
/// The Earth's field is evaluated again when the vehicle has moved 1 km from where it was last
/// evaluated: it changes by less than 1e-4 gauss over that distance. Currents' fields are not
/// modelled.
class MagnetometerModel {
 public:
  MagnetometerModel() = default;
  MagnetometerModel(const base::MagnetometerSheet& sheet, const base::LocalProjection& projection,
                    double decimal_year, std::uint64_t seed);

  /// @param own_field_W  the world's own field, gauss; nullopt: the Earth's
  MagnetometerSample sample(base::SimTime time, const BodyState& state,
                            const std::optional<Eigen::Vector3d>& own_field_W = {});

  const base::MagnetometerSheet& sheet() const { return sheet_; }

 private:
  void follow(const Eigen::Vector3d& p_W);

  base::MagnetometerSheet sheet_;
  Eigen::Vector3d stddev_gauss_ = Eigen::Vector3d::Zero();  // white, one sample
  base::LocalProjection projection_;
  double decimal_year_ = 0;
  base::NormalRandom random_;
  GaussMarkov<3> walk_;
  Eigen::Vector3d field_W_ = Eigen::Vector3d::Zero();         // gauss
  Eigen::Vector3d evaluated_at_W_ = Eigen::Vector3d::Zero();  // m
};

}  // namespace cas::sim
