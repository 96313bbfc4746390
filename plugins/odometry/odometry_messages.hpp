// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "libsim/api/odometry_sample.hpp"
#include "mavlink/common/odometry.hpp"
#include "mavlink/common/vision_position_estimate.hpp"
#include "plugins/odometry/odometry_model.hpp"

namespace cas::sim {

/// ODOMETRY: pose in `frame` of the parameters, velocity and rates in MAV_FRAME_BODY_FRD. The
/// covariances are the variances of the white noise, between which there is no correlation; the
/// drift is not in them, because such a sensor does not know it.
mavlink::common::Odometry to_odometry(const OdometrySample& sample, const OdometryParams& params);

/// VISION_POSITION_ESTIMATE: the pose alone, with the same covariance.
mavlink::common::VisionPositionEstimate to_vision_position_estimate(const OdometrySample& sample,
                                                                    const OdometryParams& params);

}  // namespace cas::sim
