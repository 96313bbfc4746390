// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <array>
#include <cmath>

#include "base/earth/frames.hpp"
#include "tests/fcu/support/closed_loop.hpp"

namespace cas::fcu::test {

/// Root mean squares pooled over time and flights.
struct FlightStatistics {
  Eigen::Array3d tracking_m = Eigen::Array3d::Zero();  ///< truth minus reference
  Eigen::Array3d estimate_m = Eigen::Array3d::Zero();  ///< estimate minus truth
  Eigen::Array3d control_m = Eigen::Array3d::Zero();   ///< estimate minus reference
  double yaw_rad = 0;                                  ///< truth minus reference
  double estimate_yaw_rad = 0;                         ///< estimate minus truth

  void add(ClosedLoop& loop, const Eigen::Vector3d& reference_N, double yaw_reference_rad) {
    const FlightStatus& status = loop.fcu().status();
    const auto& truth = loop.truth();
    tracking_m += (truth.p_N - reference_N).array().square();
    estimate_m += (status.p_N - truth.p_N).array().square();
    control_m += (status.p_N - reference_N).array().square();
    const auto wrapped = [](double a) { return std::pow(base::wrap_angle(a), 2); };
    yaw_rad += wrapped(loop.yaw() - yaw_reference_rad);
    estimate_yaw_rad += wrapped(base::euler_rpy(status.q_ND).z() - loop.yaw());
    ++count_;
  }

  FlightStatistics rms() const {
    FlightStatistics out;
    const double n = static_cast<double>(count_);
    out.tracking_m = (tracking_m / n).sqrt();
    out.estimate_m = (estimate_m / n).sqrt();
    out.control_m = (control_m / n).sqrt();
    out.yaw_rad = std::sqrt(yaw_rad / n);
    out.estimate_yaw_rad = std::sqrt(estimate_yaw_rad / n);
    return out;
  }

 private:
  std::int64_t count_ = 0;
};

}  // namespace cas::fcu::test
