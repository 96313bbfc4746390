// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>

#include "base/time/clock.hpp"
#include "fcu/protocols/command.hpp"

namespace cas::fcu {

struct FcuCore;

/// MAV_CMD_PREFLIGHT_CALIBRATION for the gyro: the estimate begins anew at rest, and its biases
/// with it. It takes seconds, so it is answered IN_PROGRESS until it has succeeded, failed or been
/// cancelled.
class GyroCalibration {
 public:
  using Result = mavlink::common::MavResult;

  struct Progress {
    Command command;  ///< the one that began it
    Result result{};
    int percent = 0;
  };

  /// Begins or cancels. What else the command could calibrate does not exist here: UNSUPPORTED.
  Result on_command(const Command& command, FcuCore& core, base::RunTime now);
  /// What is to be told to the sender of the command that runs, if anything.
  std::optional<Progress> update(FcuCore& core, base::RunTime now);

 private:
  std::optional<Progress> end(Result result, FcuCore& core);

  std::optional<Command> running_;
  bool cancelled_ = false;
  base::RunTime begin_;
  base::RunTime told_;
};

}  // namespace cas::fcu
