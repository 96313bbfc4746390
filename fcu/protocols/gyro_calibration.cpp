// SPDX-License-Identifier: BSD-3-Clause
#include "fcu/protocols/gyro_calibration.hpp"

#include <algorithm>
#include <cmath>

#include "fcu/estimation/estimator.hpp"
#include "fcu/flight/commander.hpp"
#include "fcu/flight/status_texts.hpp"

namespace cas::fcu {

using base::RunTime;
using mavlink::common::MavResult;

namespace {

constexpr double kRest_s = 2.0;       // of samples at rest: the bias is then known
constexpr double kPatience_s = 20.0;  // moved or without data for this long: failed
constexpr double kTellPeriod_s = 0.5;

}  // namespace

MavResult GyroCalibration::on_command(const Command& command, RunTime now) {
  const auto& p = command.param;
  const bool nothing_asked = std::all_of(
      p.begin(), p.end(), [](double value) { return !std::isfinite(value) || value == 0; });
  if (nothing_asked) {  // that is how ground stations cancel
    cancelled_ = running_.has_value();
    return MavResult::kAccepted;
  }
  if (p[0] != 1) return MavResult::kUnsupported;
  if (parts_.commander.armed() || running_) return MavResult::kTemporarilyRejected;
  parts_.restart_estimate();
  running_ = command;
  cancelled_ = false;
  begin_ = told_ = now;
  parts_.texts.info("[cal] calibration started: 2 gyro");
  return MavResult::kInProgress;
}

std::optional<GyroCalibration::Progress> GyroCalibration::end(Result result) {
  const bool good = result == MavResult::kAccepted;
  parts_.texts.info(good ? "[cal] calibration done: gyro"
                         : "[cal] calibration failed: gyro not at rest, or cancelled");
  const Progress progress{*running_, result, good ? 100 : 0};
  running_.reset();
  return progress;
}

std::optional<GyroCalibration::Progress> GyroCalibration::update(RunTime now) {
  if (!running_) return std::nullopt;
  if (cancelled_) return end(MavResult::kCancelled);
  const double rest_s = parts_.estimator.rest_s();
  if (parts_.estimator.aligned() && rest_s >= kRest_s) return end(MavResult::kAccepted);
  if (base::to_seconds(now - begin_) > kPatience_s) return end(MavResult::kFailed);
  if (base::to_seconds(now - told_) < kTellPeriod_s) return std::nullopt;
  told_ = now;
  return Progress{*running_, MavResult::kInProgress,
                  static_cast<int>(100 * std::min(rest_s / kRest_s, 0.99))};
}

}  // namespace cas::fcu
