// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "casd/casctl/monitor/monitor_state.hpp"
#include "casd/casctl/monitor/screen_text.hpp"

namespace cas::casctl {

/// Panes side by side: 1, from 160 columns 2, from 220 columns 3.
std::size_t panes(std::size_t width);

/// The whole screen: `rows` lines, each exactly `width` columns. 60 x 20 has room for the
/// essentials.
///
///   title: vehicle, casd                                               whole width
///   links      | open message | vehicle: attitude, position            3 panes; with 2 the right
///   messages   | its plot     | gains                                  ones share a pane; with 1
///   note, answer, text of the vehicle                                  a page at a time
///   prompt or keys
///
/// Where there is no room, whole columns, words and parts are left out, the least important first.
Block render(const MonitorState& state, std::size_t rows, std::size_t width, double now_s);

}  // namespace cas::casctl
