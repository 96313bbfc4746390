// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>

#include "base/clock.hpp"
#include "fcu/telemetry.hpp"
#include "mavlink/common/command_int.hpp"
#include "mavlink/common/command_long.hpp"
#include "mavlink/common/enums.hpp"
#include "mavlink/common/set_mode.hpp"
#include "mavlink_gen/runtime/packet.hpp"

namespace cas::fcu {

struct FcuCore;

/// A command from COMMAND_LONG or COMMAND_INT in one form. Latitude and longitude are in degrees.
struct Command {
  mavlink::common::MavCmd id{};
  std::array<double, 7> param{};
  mavlink::common::MavFrame frame = mavlink::common::MavFrame::kGlobal;
  mav::Source from;
  int version = 2;
};

/// Carries out commands and acknowledges each one.
class CommandHandler {
 public:
  explicit CommandHandler(Telemetry& telemetry) : telemetry_(telemetry) {}

  void on_long(const mavlink::common::CommandLong& m, mav::Source from, int version, FcuCore& core,
               base::RunTime now);
  void on_int(const mavlink::common::CommandInt& m, mav::Source from, int version, FcuCore& core,
              base::RunTime now);
  void on_set_mode(const mavlink::common::SetMode& m, mav::Source from, int version, FcuCore& core,
                   base::RunTime now);

 private:
  using Result = mavlink::common::MavResult;
  void acknowledge(const Command& command, Result result, FcuCore& core) const;
  Result execute(const Command& command, FcuCore& core, base::RunTime now);
  Result flight_command(const Command& command, FcuCore& core, base::RunTime now);
  Result information_command(const Command& command, FcuCore& core, base::RunTime now);

  Telemetry& telemetry_;
};

}  // namespace cas::fcu
