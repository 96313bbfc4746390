// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "casd/casctl/monitor/monitor_state.hpp"
#include "casd/casctl/monitor/screen_text.hpp"

namespace cas::casctl {

// The parts of the screen, each a pure function of the state, the time and its room.

/// "0.4 s", "12 s", "3 min".
std::string age_text(double age_s);
/// "in_air", as the vehicle of this summary said it lately; else how old what it said is.
std::string landed_text(const MonitorState& state, const nlohmann::json& summary, double now_s);

/// A line for each link; the reason of one that is down where the table has no room for it.
Block link_section(const MonitorState& state, double now_s, std::size_t width);

/// A line for each message, link, direction and sender, around the selected one.
Block message_section(const MonitorState& state, double now_s, std::size_t width, std::size_t rows);

/// The open message: its fields with units and course, and a plot of the selected one.
Block field_section(const MonitorState& state, double now_s, std::size_t width, std::size_t rows);

/// P, I and D of each loop.
Block gain_section(const MonitorState& state, double now_s, std::size_t width, std::size_t rows);

/// State, attitude, position, horizon, trail and texts of the vehicle.
Block vehicle_section(const MonitorState& state, double now_s, std::size_t width, std::size_t rows);

/// What there is of the vehicle in a line or two; that there is none in as many as it takes.
Block vehicle_summary(const MonitorState& state, double now_s, std::size_t width);

/// The keys and the commands of the prompt: 80 columns by 19 lines have room for them.
Block help_section(const MonitorState& state, std::size_t width, std::size_t rows);

}  // namespace cas::casctl
