// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <optional>
#include <utility>

#include "base/time/clock.hpp"
#include "fcu/protocols/flight_commands.hpp"
#include "mavlink/common/enums.hpp"

namespace cas::fcu {

class Commander;
class Estimator;
class StatusTexts;

/// MAV_CMD_PREFLIGHT_CALIBRATION for the gyro: the estimator and its biases restart at rest. It
/// takes seconds, so it is answered IN_PROGRESS until it has succeeded, failed or been cancelled.
class GyroCalibration {
 public:
  using Result = mavlink::common::MavResult;

  struct Parts {
    const Commander& commander;
    const Estimator& estimator;
    StatusTexts& texts;
    std::function<void()> restart_estimate;  ///< restarts the estimator, as at start
  };
  explicit GyroCalibration(Parts parts) : parts_(std::move(parts)) {}

  struct Progress {
    Command command;  ///< the one that began it
    Result result{};
    int percent = 0;
  };

  /// Begins or cancels. UNSUPPORTED for other calibrations than the gyro's.
  Result on_command(const Command& command, base::RunTime now);
  /// Progress to report to the sender of the running command, if any.
  std::optional<Progress> update(base::RunTime now);

 private:
  std::optional<Progress> end(Result result);

  Parts parts_;
  std::optional<Command> running_;
  bool cancelled_ = false;
  base::RunTime begin_;
  base::RunTime told_;
};

}  // namespace cas::fcu
