// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "casd/casctl/monitor/monitor_state.hpp"
#include "casd/casctl/monitor/screen_text.hpp"

namespace cas::casctl {

/// P, I and D of each loop.
Block gain_section(const MonitorState& state, double now_s, std::size_t width, std::size_t rows);

/// A line for each link; the reason of one that is down where the table has no room for it.
Block link_section(const MonitorState& state, double now_s, std::size_t width);

/// A line for each message, link, direction and sender, around the selected one.
Block message_section(const MonitorState& state, double now_s, std::size_t width, std::size_t rows);

/// The open message: its fields with units and course, and a plot of the selected one.
Block field_section(const MonitorState& state, double now_s, std::size_t width, std::size_t rows);

/// "in_air", the recent landed state of the summary's vehicle; of an old one its age.
std::string landed_text(const MonitorState& state, const nlohmann::json& summary, double now_s);

/// State, attitude, position, horizon, trail and texts of the vehicle.
Block vehicle_section(const MonitorState& state, double now_s, std::size_t width, std::size_t rows);

/// The vehicle in a line or two; that there is none in as many as it takes.
Block vehicle_summary(const MonitorState& state, double now_s, std::size_t width);

}  // namespace cas::casctl
