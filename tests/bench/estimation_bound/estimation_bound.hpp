// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>

#include "fcu/estimation/sensor_figures.hpp"

namespace cas::fcu {

/// Smallest errors (1 sigma) that any unbiased estimator can have, averaged over time.
struct EstimationBound {
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();  ///< north, east, down
  Eigen::Vector3d velocity_m_s = Eigen::Vector3d::Zero();
  Eigen::Vector3d attitude_rad = Eigen::Vector3d::Zero();  ///< about north, east, down
};

struct BoundScenario {
  double rest_s = 5;      ///< on the ground, known to stand still, before the flight
  double settle_s = 20;   ///< flight before the average begins
  double average_s = 40;  ///< flight that is averaged
  double earth_field_gauss_N[3] = {0.2135, 0.0127, 0.4331};  ///< at the default home
};

/// Error covariance of a hovering vehicle by the time-varying Riccati equation of all error states
/// (attitude, velocity, position, gyro and accelerometer bias, earth and body field, barometer
/// offset): level, heading north, no late fixes. An own, dense implementation: the yardstick for
/// the estimator, not its code.
EstimationBound flight_bound(const SensorFigures& figures, const BoundScenario& scenario = {});

/// The same in the steady state of an endless flight, with the walks that the filter assumes for
/// whatever the sensor set calls constant.
EstimationBound steady_bound(const SensorFigures& figures);

}  // namespace cas::fcu
