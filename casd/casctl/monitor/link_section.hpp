// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "casd/casctl/monitor/monitor_state.hpp"
#include "casd/casctl/monitor/screen_text.hpp"

namespace cas::casctl {

/// A line for each link; the reason of one that is down where the table has no room for it.
Block link_section(const MonitorState& state, double now_s, std::size_t width);

}  // namespace cas::casctl
