// SPDX-License-Identifier: BSD-3-Clause
#include "casd/casctl/monitor/sections.hpp"

#include <algorithm>

#include "casd/casctl/monitor/text_table.hpp"
#include "casd/casctl/session/text.hpp"

namespace cas::casctl {
namespace {

using nlohmann::json;

}  // namespace

Block gain_section(const MonitorState& state, double now_s, std::size_t width, std::size_t rows) {
  const Presence vehicle = presence(state, now_s);
  const bool here = vehicle.kind == Presence::Kind::kHere;
  const bool has_focus = state.page == MonitorState::Page::kGains;
  std::vector<TextRow> lines;
  for (std::size_t i = 0; i < state.gains.size(); ++i) {
    const json& gains = state.gains[i];
    const auto cell = [&](const char* key) {
      return gains.contains(key) ? value_text(gains[key]) : std::string("-");
    };
    lines.push_back({{gains.value("loop", "?"), cell("p"), cell("i"), cell("d")},
                     !here                                   ? Style::kDim
                     : has_focus && i == state.selected_gain ? Style::kSelected
                                                             : Style::kPlain});
  }
  const std::string age =
      state.gains.empty() ? "" : "read " + age_text(now_s - state.gains_at_s) + " ago";
  Block block{join({{"GAINS", Style::kHeader},
                    {age, Style::kHeader, 2},
                    {has_focus ? "Enter: edit" : "g: select", Style::kHeader, 3}},
                   width)};
  if (!here) {
    append(block, wrapped(vehicle.kind == Presence::Kind::kNone ? "No vehicle: no gains."
                          : lines.empty() ? "The vehicle does not answer: its gains are unknown."
                                          : "The vehicle does not answer: these are the last ones.",
                          width, Style::kBad));
  } else if (state.gains_fault) {
    append(block, wrapped(*state.gains_fault, width, Style::kBad));
  } else if (state.gains_asked_s) {
    block.emplace_back("asked for " + age_text(now_s - *state.gains_asked_s) + " ago", Style::kDim);
  }
  if (lines.empty()) return block;
  const TextTable table({{"LOOP", 0}, {"P", 1, true}, {"I", 2, true}, {"D", 3, true}}, lines,
                        width);
  append(block, table.scrolled(state.selected_gain, rows - std::min(rows, block.size())));
  return block;
}

}  // namespace cas::casctl
