// SPDX-License-Identifier: BSD-3-Clause
#include "hils/measure/reference_track.hpp"

#include <cmath>

#include "base/time/clock.hpp"

namespace cas::hils {

std::vector<PoseSample> reference_track(const RunRecord& record, double period_s) {
  const std::vector<PoseSample>& truth = record.truth();
  const Pose start = truth.empty() ? Pose{} : truth.front().pose;
  std::vector<PoseSample> track;
  bool climbed = false;
  for (const Stage& stage : record.stages) {
    climbed = climbed || stage.step.kind == StepKind::kTakeoff;
    if (stage.step.kind == StepKind::kLand) climbed = false;
    if (!climbed) continue;
    const double begin = base::to_seconds(stage.begin);
    const double end = base::to_seconds(stage.end);
    for (double t = begin; t < end; t += period_s) {
      const std::int64_t time_us = std::llround(t * 1e6);
      const Pose pose = reference_at(stage, time_us);
      track.push_back({.time_us = time_us,
                       .pose = {.x_m = pose.x_m + start.x_m,
                                .y_m = pose.y_m + start.y_m,
                                .z_m = pose.z_m + start.z_m,
                                .yaw_rad = pose.yaw_rad}});
    }
  }
  return track;
}

}  // namespace cas::hils
