// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>

#include "base/time/clock.hpp"
#include "fcu/core/outbox.hpp"
#include "fcu/flight/status_texts.hpp"
#include "fcu/protocols/flight_commands.hpp"
#include "fcu/protocols/gyro_calibration.hpp"
#include "fcu/protocols/telemetry.hpp"
#include "mavlink/common/command_int.hpp"
#include "mavlink/common/command_long.hpp"
#include "mavlink/common/enums.hpp"
#include "mavlink/common/set_mode.hpp"

namespace cas::fcu {

/// Carries out commands and acknowledges each one. A repetition of a command whose answer was lost
/// (`confirmation` above 0) gets the same answer again and does nothing twice.
class CommandHandler {
 public:
  /// All outlive it.
  CommandHandler(const CommandTarget& target, Outbox& outbox, StatusTexts& texts,
                 Telemetry& telemetry);

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

  CommandTarget target_;
  Outbox& outbox_;
  StatusTexts& texts_;
  Telemetry& telemetry_;
  GyroCalibration calibration_;
  std::optional<Answered> last_;
};

}  // namespace cas::fcu
