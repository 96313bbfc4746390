// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>

#include "base/config/sensor_sheets.hpp"
#include "base/random.hpp"
#include "base/time/clock.hpp"
#include "libsim/api/messages.hpp"
#include "libsim/api/world.hpp"
#include "plugins/common/gauss_markov.hpp"

namespace cas::sim {

/// Velocity of the tube through the air along its direction, m/s: positive when the air meets its
/// opening.
double speed_along_tube(const BodyState& body, const Eigen::Vector3d& wind_W,
                        const base::AirspeedSheet& sheet);

/// A pitot tube: dynamic pressure of incompressible air (1.5 % low at Mach 0.25), position error,
/// first-order lag of the pressure, bias, drift and white noise. Air that meets the tube from
/// behind reads negative; the angle of the flow enters by the component along the tube alone.
class AirspeedModel {
 public:
  AirspeedModel() = default;
  /// @param step_s  time between two calls of follow()
  AirspeedModel(const base::AirspeedSheet& sheet, double step_s, std::uint64_t seed);

  /// Each step: the pressure in the sensor follows that at the tube. The first call sets it.
  /// @param speed_m_s  along the tube
  void follow(double speed_m_s, double air_density_kg_m3);
  AirspeedSample sample(base::SimTime time);

  const base::AirspeedSheet& sheet() const { return sheet_; }

 private:
  base::AirspeedSheet sheet_;
  double stddev_pa_ = 0;  ///< white, one sample
  double share_ = 1;      ///< of the way to the pressure at the tube in one step
  base::NormalRandom random_;
  GaussMarkov<1> drift_;
  std::optional<double> pressure_pa_;  ///< in the sensor
};

}  // namespace cas::sim
