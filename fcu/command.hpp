// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>

#include "mavlink/common/enums.hpp"
#include "mavlink_gen/runtime/packet.hpp"

namespace cas::fcu {

/// A command from COMMAND_LONG or COMMAND_INT in one form. Latitude and longitude are in degrees.
struct Command {
  mavlink::common::MavCmd id{};
  std::array<double, 7> param{};
  mavlink::common::MavFrame frame = mavlink::common::MavFrame::kGlobal;
  mav::Source from;
  int version = 2;
};

}  // namespace cas::fcu
