// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "casd/casctl/monitor/monitor_state.hpp"
#include "casd/casctl/monitor/screen_text.hpp"

namespace cas::casctl {

/// P, I and D of each loop.
Block gain_section(const MonitorState& state, double now_s, std::size_t width, std::size_t rows);

}  // namespace cas::casctl
