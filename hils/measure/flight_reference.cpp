// SPDX-License-Identifier: BSD-3-Clause
#include "hils/measure/flight_reference.hpp"

namespace cas::hils {

Pose reference_at(const Stage& stage, std::int64_t time_us) {
  Pose pose{.x_m = stage.reference_m.x(),
            .y_m = stage.reference_m.y(),
            .z_m = stage.reference_m.z(),
            .yaw_rad = stage.reference_yaw_rad};
  if (stage.step.kind != StepKind::kTrajectory) return pose;
  const auto accepted_us = static_cast<std::int64_t>(base::to_time_usec(stage.accepted));
  if (time_us < accepted_us) return pose;
  const Eigen::Vector3d offset =
      stage.step.trajectory.pattern()
          .at(1e-6 * static_cast<double>(time_us - accepted_us), Eigen::Vector3d::Zero(), 0)
          .p_N;
  pose.x_m += offset.x();
  pose.y_m += offset.y();
  pose.z_m -= offset.z();
  return pose;
}

}  // namespace cas::hils
