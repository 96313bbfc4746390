// SPDX-License-Identifier: BSD-3-Clause
#include "casd/casctl/monitor/monitor_view.hpp"

#include <fmt/format.h>
#include <algorithm>
#include <utility>

#include "casd/casctl/monitor/prompt.hpp"
#include "casd/casctl/monitor/sections.hpp"
#include "casd/casctl/session/text.hpp"

namespace cas::casctl {
namespace {

using nlohmann::json;
using Page = MonitorState::Page;

/// "vehicle 1 PX4 HIL ARMED HOLD in_air 2.52 m", or that there is none.
std::vector<Segment> vehicle_title(const MonitorState& state, const Presence& vehicle,
                                   double now_s) {
  const json& summary = vehicle.summary;
  const std::string name = fmt::format("vehicle {}", summary.value("system", 0));
  switch (vehicle.kind) {
    case Presence::Kind::kUnknown:
      return {{"CASD DOES NOT ANSWER since " + age_text(vehicle.age_s), Style::kAlarm}};
    case Presence::Kind::kNone:
      return {{"NO VEHICLE", Style::kAlarm}};
    case Presence::Kind::kLost:
      return {{name, Style::kTitle},
              {summary.value("autopilot", "?"), Style::kTitle, 5},
              {"LOST since " + age_text(vehicle.age_s), Style::kAlarm}};
    case Presence::Kind::kHere:
      break;
  }
  const bool hil = summary.value("hil", false);
  const bool is_same = state.vehicle.value("system", 0) == summary.value("system", 0);
  const double told_s =
      state.vehicle.value("altitude_age_s", 0.0) + overdue_s(state, state.vehicle_at_s, now_s);
  const bool told = is_same && state.vehicle.contains("altitude_m") && told_s <= kStale_s;
  const std::size_t others = state.status.value("vehicles", json::array()).size() - 1;
  return {
      {name, Style::kTitle, 1},
      {summary.value("autopilot", "?"), Style::kTitle, 6},
      {hil ? "HIL" : "NOT HIL", hil ? Style::kTitle : Style::kAlarm, hil ? 4 : 0},
      {summary.value("armed", false) ? "ARMED" : "disarmed", Style::kTitle},
      {summary.value("mode", "?"), Style::kTitle},
      {landed_text(state, summary, now_s), Style::kTitle, 2},
      {told ? fixed(state.vehicle["altitude_m"].get<double>(), 2) + " m" : "", Style::kTitle, 3},
      {others == 0 ? "" : fmt::format("and {} more (v)", others), Style::kTitle, 5}};
}

/// The bar across the top: the vehicle at the left, casd at the right.
ScreenLine title(const MonitorState& state, std::size_t width, double now_s) {
  const Presence vehicle = presence(state, now_s);
  std::vector<Segment> segments = vehicle_title(state, vehicle, now_s);
  const std::size_t left_parts = segments.size();
  if (state.paused) {
    segments.push_back({"PAUSED " + age_text(now_s - state.rows_at_s), Style::kAlarm, 1});
  }
  const double uptime_s = state.status.value("uptime_s", 0.0) + now_s - state.status_at_s;
  const bool answers = vehicle.kind != Presence::Kind::kUnknown;
  segments.push_back({"casd " + state.status.value("version", "?"), Style::kTitle, 7});
  segments.push_back({answers ? "up " + duration_text(uptime_s) : "", Style::kTitle, 8});
  segments.push_back({answers ? state.status.value("threads", "") : "", Style::kTitle, 9});
  // Keeps the segments that fit, then separates the vehicle's from casd's.
  const std::size_t room = width > 2 ? width - 2 : 0;
  std::vector<Segment> kept;
  const ScreenLine joined = join(segments, room);
  std::size_t next = 0;
  ScreenLine first(" ", Style::kTitle);
  ScreenLine second;
  for (const Span& span : joined.spans) {
    if (span.text.find_first_not_of(' ') == std::string::npos) continue;
    while (next < segments.size() && segments[next].text != span.text) ++next;
    ScreenLine& part = next < left_parts ? first : second;
    if (columns(part) > 1) part.add("  ", Style::kTitle);
    part.add(span.text, span.style);
    ++next;
  }
  second.add(" ", Style::kTitle);
  const std::size_t taken = columns(first) + columns(second);
  first.add(std::string(width > taken ? width - taken : 0, ' '), Style::kTitle).add(second);
  return fit_line(first, width, Style::kTitle);
}

/// The lines at the bottom: the last event, and the prompt or the keys.
Block bottom(const MonitorState& state, std::size_t width, double now_s) {
  Block block;
  if (state.prompt) {
    append(block, wrapped(state.hint, width, Style::kDim));
    append(block, wrapped(*state.prompt, std::max<std::size_t>(width, 2) - 1, Style::kPlain));
    if (state.prompt->ends_with(' ')) block.back().add(" ");
    block.back().add(" ", Style::kSelected).add("");  // the cursor, and nothing behind it
    return block;
  }
  const double answer_age_s = now_s - state.answer_at_s;
  constexpr double kNew_s = 3;
  const std::string age = answer_age_s > kNew_s ? " (" + age_text(answer_age_s) + " ago)" : "";
  if (!state.answer.empty()) {
    append(block,
           wrapped(state.answer + age, width, state.answer_bad ? Style::kBad : Style::kGood));
  }
  append(block, wrapped(state.note, width, state.note_bad ? Style::kBad : Style::kPlain));
  const json texts = state.vehicle.value("statustexts", json::array());
  const bool here = presence(state, now_s).kind == Presence::Kind::kHere;
  if (here && !texts.empty() && panes(width) == 1) {
    const json& text = texts.back();
    append(block, wrapped(age_text(text.value("age_s", 0.0) + now_s - state.vehicle_at_s) +
                              " ago: " + text.value("text", ""),
                          width, Style::kDim));
  }
  std::string filters;
  if (!state.link.empty()) filters += " link " + state.link;
  if (!state.direction.empty()) filters += " " + state.direction;
  if (!state.filter.empty()) filters += " /" + state.filter;
  block.push_back(join({{filters.empty() ? "" : "only" + filters, Style::kBad},
                        {": command", Style::kDim, 1},
                        {"Enter open", Style::kDim, 3},
                        {"a attitude", Style::kDim, 4},
                        {"g gains", Style::kDim, 5},
                        {"/ filter", Style::kDim, 7},
                        {"Tab link", Style::kDim, 8},
                        {"d direction", Style::kDim, 9},
                        {"s sort", Style::kDim, 10},
                        {state.paused ? "p goes on" : "p pause", Style::kDim, 6},
                        {"? help", Style::kDim, 0},
                        {"q quit", Style::kDim, 2}},
                       width));
  return block;
}

Block links_and_messages(const MonitorState& state, double now_s, std::size_t width,
                         std::size_t rows) {
  Block block = link_section(state, now_s, width);
  const std::size_t most = std::max<std::size_t>(rows / 2, 2);
  if (block.size() > most) {
    const std::size_t left_out = block.size() - most + 1;
    block.resize(most - 1);
    block.emplace_back(fmt::format("and {} lines more: casctl links", left_out), Style::kDim);
  }
  append(block, message_section(state, now_s, width, rows - std::min(rows, block.size())));
  return fit_block(block, rows, width);
}

/// The vehicle above its gains.
Block vehicle_and_gains(const MonitorState& state, double now_s, std::size_t width,
                        std::size_t rows) {
  const std::size_t gains = std::min<std::size_t>(state.gains.size() + 3, rows / 3);
  Block block = fit_block(vehicle_section(state, now_s, width, rows - gains), rows - gains, width);
  append(block, fit_block(gain_section(state, now_s, width, gains), gains, width));
  return block;
}

/// One page, or the open message below the list.
Block single_pane(const MonitorState& state, double now_s, std::size_t width, std::size_t rows) {
  if (state.page == Page::kGains) {
    Block block = vehicle_summary(state, now_s, width);
    append(block, gain_section(state, now_s, width, rows - std::min(rows, block.size())));
    return block;
  }
  if (state.page == Page::kVehicle) return vehicle_section(state, now_s, width, rows);
  Block block = vehicle_summary(state, now_s, width);
  const std::size_t below = rows - std::min(rows, block.size());
  if (!state.open) {
    append(block, links_and_messages(state, now_s, width, below));
    return block;
  }
  // The list keeps a few lines, so that one may go on to the next message.
  const std::size_t shown = visible_rows(state).size() + 1;  // with the header
  const std::size_t list =
      std::min(std::max<std::size_t>(below / 4, 4), std::max<std::size_t>(shown, 2));
  append(block, fit_block(message_section(state, now_s, width, list), list, width));
  append(block, field_section(state, now_s, width, below - std::min(below, list)));
  return block;
}

Block two_panes(const MonitorState& state, double now_s, std::size_t width, std::size_t rows,
                const std::string& edge) {
  const std::size_t first = (width - 3) / 2;
  const std::size_t second = width - 3 - first;
  Block right_pane;
  if (state.open && state.page != Page::kVehicle) {
    // The message gets the rows it needs, at most three fifths.
    const std::size_t fields = state.value.value("fields", json::array()).size();
    const std::size_t message = std::min(std::max<std::size_t>(fields + 14, 16), rows * 3 / 5);
    right_pane = fit_block(field_section(state, now_s, second, message), message, second);
  }
  const std::size_t rest = rows - right_pane.size();
  constexpr std::size_t kLeastForBoth = 24;
  if (state.page == Page::kGains && rest < kLeastForBoth) {
    append(right_pane, fit_block(gain_section(state, now_s, second, rest), rest, second));
  } else if (rest >= kLeastForBoth) {
    append(right_pane, vehicle_and_gains(state, now_s, second, rest));
  } else {
    append(right_pane, fit_block(vehicle_section(state, now_s, second, rest), rest, second));
  }
  return beside(links_and_messages(state, now_s, first, rows), edge, right_pane);
}

Block three_panes(const MonitorState& state, double now_s, std::size_t width, std::size_t rows,
                  const std::string& edge) {
  const std::size_t first = (width - 6) * 2 / 5;
  const std::size_t second = (width - 6 - first) / 2;
  const std::size_t third = width - 6 - first - second;
  const Block middle = fit_block(field_section(state, now_s, second, rows), rows, second);
  return beside(beside(links_and_messages(state, now_s, first, rows), edge, middle), edge,
                vehicle_and_gains(state, now_s, third, rows));
}

/// The keys and the commands of the prompt: 80 columns by 19 lines have room for them.
Block help_section(const MonitorState& state, std::size_t width, std::size_t rows) {
  Block all;
  const auto key = [&](const std::string& name, const std::string& does) {
    constexpr std::size_t kNames = 13;
    const std::vector<std::string> lines = wrap(does, width > kNames + 10 ? width - kNames : width);
    for (std::size_t i = 0; i < lines.size(); ++i) {
      all.emplace_back(left(i == 0 ? name : "", kNames) + lines[i]);
    }
  };
  key("up, down", "select a message (j, k; PgUp, PgDn by half a screen)");
  key("Enter", "open it: fields, units, course and a plot; again: close it");
  key("left, right", "the field that is plotted");
  key("Tab", "messages of the next link, then of all");
  key("d", "received, sent, dropped, all");
  key("s", "sort by name, rate, age, count");
  key("/", "filter by name; Esc ends it");
  key("p", "hold messages and values still; vehicle and links go on");
  key("a", "attitude and position: horizon, trail, what the vehicle said");
  key("g", "gains; Enter there edits P, I and D of the loop");
  key("v", "the next vehicle, where casd hears several");
  key(":", "a command; Tab completes, up brings back earlier ones, Esc leaves");
  key("q", "quit");
  all.emplace_back("COMMANDS, each after a colon", Style::kHeader);
  std::string line;
  for (const std::string& usage : prompt_usages()) {
    constexpr std::size_t kGap = 3;
    if (!line.empty() && columns(line) + kGap + columns(usage) > width) {
      all.emplace_back(std::exchange(line, ""));
    }
    line += (line.empty() ? "" : std::string(kGap, ' ')) + usage;
  }
  all.emplace_back(line);
  const std::size_t room = rows > 1 ? rows - 1 : 0;
  const std::size_t most = all.size() > room ? all.size() - room : 0;
  const std::size_t first = std::min(state.help_top, most);
  Block block{join(
      {{"KEYS", Style::kHeader}, {most > 0 ? "up and down show the rest" : "", Style::kHeader}},
      width)};
  for (std::size_t i = first; i < all.size() && i < first + room; ++i) block.push_back(all[i]);
  return block;
}

}  // namespace

std::size_t panes(std::size_t width) {
  constexpr std::size_t kTwo = 160;
  constexpr std::size_t kThree = 220;
  return width >= kThree ? 3 : width >= kTwo ? 2 : 1;
}

Block render(const MonitorState& state, std::size_t rows, std::size_t width, double now_s) {
  Block screen{title(state, width, now_s)};
  const Block below = bottom(state, width, now_s);
  const std::size_t middle = rows - std::min(rows, screen.size() + below.size());
  const std::string edge = state.unicode ? " │ " : " | ";
  Block panes_block;
  if (state.page == Page::kHelp) {
    panes_block = help_section(state, width, middle);
  } else if (panes(width) == 1) {
    panes_block = single_pane(state, now_s, width, middle);
  } else if (panes(width) == 2) {
    panes_block = two_panes(state, now_s, width, middle, edge);
  } else {
    panes_block = three_panes(state, now_s, width, middle, edge);
  }
  append(screen, fit_block(panes_block, middle, width));
  append(screen, fit_block(below, below.size(), width));
  if (screen.size() > rows) screen.resize(rows);
  return screen;
}

}  // namespace cas::casctl
