// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "casd/casctl/monitor/monitor_state.hpp"
#include "casd/casctl/monitor/screen_text.hpp"

namespace cas::casctl {

/// A line for each message, link, direction and sender, around the selected one.
Block message_section(const MonitorState& state, double now_s, std::size_t width, std::size_t rows);

/// The open message: its fields with units and course, and a plot of the selected one.
Block field_section(const MonitorState& state, double now_s, std::size_t width, std::size_t rows);

}  // namespace cas::casctl
