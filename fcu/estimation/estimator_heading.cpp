// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>

#include "base/earth/frames.hpp"
#include "fcu/estimation/estimator.hpp"

namespace cas::fcu {

using Eigen::Vector3d;

/// A receiver that starts without a fix tells too late where on earth the compass stands: the
/// heading is then found here, from the tilt that is known and one reading. It begins anew; place
/// and velocity stay as they are.
void Estimator::align_heading(const Vector3d& field_D) {
  using C = ErrorCovariance;
  const Vector3d rpy = base::euler_rpy(state_.q_ND);
  const Vector3d level = base::quaternion_rpy(rpy.x(), rpy.y(), 0) * field_D;
  const double yaw = std::atan2(state_.earth_field_N.y(), state_.earth_field_N.x()) -
                     std::atan2(level.y(), level.x());
  state_.q_ND = base::quaternion_rpy(rpy.x(), rpy.y(), base::wrap_angle(yaw));
  covariance_.reset_block(C::kTheta + 2, 1, params_.tilt_initial_rad * params_.tilt_initial_rad);
  history_.clear();
  heading_aligned_ = true;
}

}  // namespace cas::fcu
