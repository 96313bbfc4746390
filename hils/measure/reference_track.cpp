// SPDX-License-Identifier: BSD-3-Clause
#include "hils/measure/reference_track.hpp"

#include <cmath>

#include "base/time/clock.hpp"
#include "hils/measure/step_figures.hpp"

namespace cas::hils {

std::vector<PoseSample> reference_track(const RunRecord& record, double period_s) {
  const std::vector<PoseSample>& truth = record.truth();
  std::vector<PoseSample> track;
  bool climbed = false;
  for (const Stage& stage : record.stages) {
    climbed = climbed || stage.step.kind == StepKind::kTakeoff;
    if (stage.step.kind == StepKind::kLand) climbed = false;
    if (!climbed || stage.step.kind == StepKind::kTransition) continue;  // on no path
    const ReferenceAt reference = stage.circle_m > 0 && !truth.empty()
                                      ? circle_reference(stage, truth)
                                      : reference_in_truth(stage, truth);
    const double begin = base::to_seconds(stage.begin);
    const double end = base::to_seconds(stage.end);
    for (double t = begin; t < end; t += period_s) {
      const std::int64_t time_us = std::llround(t * 1e6);
      track.push_back({.time_us = time_us, .pose = reference(time_us)});
    }
  }
  return track;
}

}  // namespace cas::hils
