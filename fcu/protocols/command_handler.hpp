// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>

#include "base/time/clock.hpp"
#include "fcu/protocols/flight_commands.hpp"
#include "fcu/protocols/telemetry.hpp"
#include "mavlink/common/command_int.hpp"
#include "mavlink/common/command_long.hpp"
#include "mavlink/common/enums.hpp"
#include "mavlink/common/set_mode.hpp"

namespace cas::fcu {

struct FcuCore;

/// MAV_CMD_PREFLIGHT_CALIBRATION for the gyro: the estimate begins anew at rest, and its biases
/// with it. It takes seconds, so it is answered IN_PROGRESS until it has succeeded, failed or been
/// cancelled.
class GyroCalibration {
 public:
  using Result = mavlink::common::MavResult;

  explicit GyroCalibration(FcuCore& core) : core_(core) {}

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

  FcuCore& core_;
  std::optional<Command> running_;
  bool cancelled_ = false;
  base::RunTime begin_;
  base::RunTime told_;
};

/// Carries out commands and acknowledges each one. A repetition of a command whose answer was lost
/// (`confirmation` above 0) gets the same answer again and does nothing twice.
class CommandHandler {
 public:
  CommandHandler(FcuCore& core, Telemetry& telemetry)
      : core_(core), telemetry_(telemetry), calibration_(core) {}

  void on_long(const mavlink::common::CommandLong& m, mav::Source from, int version,
               base::RunTime now);
  void on_int(const mavlink::common::CommandInt& m, mav::Source from, int version,
              base::RunTime now);
  void on_set_mode(const mavlink::common::SetMode& m, mav::Source from, int version,
                   base::RunTime now);
  /// Continues a calibration.
  void update(base::RunTime now);

 private:
  using Result = mavlink::common::MavResult;
  struct Answered {
    Command command;
    Result result{};
    base::RunTime at;
  };
  void acknowledge(const Command& command, Result result, int percent = 0);
  bool was_answered(const Command& command, base::RunTime now) const;
  void run(const Command& command, bool repeated, base::RunTime now);
  Result execute(const Command& command, base::RunTime now);
  Result information_command(const Command& command, base::RunTime now);
  Result request_message(const Command& command, base::RunTime now);

  FcuCore& core_;
  Telemetry& telemetry_;
  GyroCalibration calibration_;
  std::optional<Answered> last_;
};

}  // namespace cas::fcu
