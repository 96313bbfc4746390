// SPDX-License-Identifier: BSD-3-Clause
#include "casd/casctl/monitor/sections.hpp"

#include <fmt/format.h>
#include <algorithm>
#include <cmath>
#include <utility>

#include "casd/casctl/monitor/text_table.hpp"
#include "casd/casctl/session/text.hpp"

namespace cas::casctl {
namespace {

using nlohmann::json;

std::string short_number(double value) {
  return fmt::format("{:.{}g}", value, std::abs(value) < 1e4 ? 3 : 6);
}

/// A field of the open message with its history.
struct FieldRow {
  std::string name, value, units, range;
  const std::deque<Sample>* history = nullptr;
};

std::vector<FieldRow> field_rows(const MonitorState& state) {
  std::vector<FieldRow> rows;
  for (const json& field : state.value.value("fields", json::array())) {
    FieldRow row{.name = field.value("name", "?"),
                 .value = value_text(field.value("value", json())),
                 .units = field.value("units", ""),
                 .range = ""};
    const auto history = state.history.find(row.name);
    if (history != state.history.end() && !history->second.empty()) {
      row.history = &history->second;
      const auto less = [](const Sample& a, const Sample& b) { return a.value < b.value; };
      const auto [low, high] = std::minmax_element(row.history->begin(), row.history->end(), less);
      row.range = short_number(low->value) + " to " + short_number(high->value);
    }
    rows.push_back(std::move(row));
  }
  return rows;
}

Block field_table(const MonitorState& state, const std::vector<FieldRow>& fields, bool is_old,
                  std::size_t width, std::size_t rows) {
  constexpr std::size_t kCourse = 24;
  std::vector<TextRow> lines;
  for (std::size_t i = 0; i < fields.size(); ++i) {
    const FieldRow& field = fields[i];
    const std::string course =
        field.history == nullptr ? "" : sparkline(*field.history, kCourse, state.unicode);
    lines.push_back({{i == state.selected_field ? ">" : "", field.name, field.value, field.units,
                      field.range, left(course, kCourse)},
                     is_old ? Style::kDim : Style::kPlain});
  }
  return TextTable(
             {{"", 1}, {"FIELD", 0}, {"VALUE", 0, true}, {"UNIT", 2}, {"RANGE", 4}, {"COURSE", 3}},
             lines, width)
      .scrolled(state.selected_field, rows);
}

/// The selected field, and as many of those behind it as have room.
Block field_plots(const MonitorState& state, const std::vector<FieldRow>& fields, double now_s,
                  std::size_t width, std::size_t rows) {
  constexpr std::size_t kComfortable = 12;  // lines of one plot, with its title
  constexpr std::size_t kMost = 18;
  std::vector<const FieldRow*> shown;
  for (std::size_t i = state.selected_field; i < fields.size(); ++i) {
    const bool has_room = shown.empty() || (shown.size() + 1) * kComfortable <= rows;
    const bool is_selected = i == state.selected_field;
    if (has_room && (is_selected || fields[i].history != nullptr)) shown.push_back(&fields[i]);
  }
  Block block;
  for (const FieldRow* field : shown) {
    const std::string title = field->name + (field->units.empty() ? "" : " in " + field->units) +
                              (field->history == nullptr ? ": no number to plot" : "");
    const bool is_first = field == shown.front();
    block.push_back(join(
        {{title, Style::kHeader}, {is_first ? "left, right: next field" : "", Style::kHeader, 1}},
        width));
    if (field->history == nullptr) continue;
    append(block, plot(*field->history, state.paused ? state.value_at_s : now_s, width,
                       std::min(rows / shown.size(), kMost) - 1, state.unicode));
  }
  return block;
}

/// "ATTITUDE on fcu from 1/1, 0.1 s old".
ScreenLine field_title(const MonitorState& state, double age_s, bool is_old, std::size_t width) {
  const MessageKey& key = *state.open;
  return join({{key.name, Style::kHeader},
               {"on " + key.link, Style::kHeader, 2},
               {fmt::format("from {}/{}", key.system, key.component), Style::kHeader, 3},
               {age_text(age_s) + " old", is_old ? Style::kBad : Style::kHeader, 1},
               {state.paused ? "PAUSED" : "", Style::kBad, 1}},
              width, 1);
}

}  // namespace

Block message_section(const MonitorState& state, double now_s, std::size_t width,
                      std::size_t rows) {
  const std::vector<MessageRow> shown = visible_rows(state);
  const bool old = is_stale(state, now_s);
  const double look_age_s = now_s - state.rows_at_s;
  const auto at = std::find_if(shown.begin(), shown.end(),
                               [&](const MessageRow& row) { return state.selected == row.key; });
  const auto index = static_cast<std::size_t>(at == shown.end() ? 0 : at - shown.begin());
  std::vector<TextRow> lines;
  for (const MessageRow& row : shown) {
    const double age_s = row.age_s + look_age_s;
    const Style style = state.selected == row.key ? Style::kSelected
                        : old || age_s > kStale_s ? Style::kDim
                                                  : Style::kPlain;
    lines.push_back(
        {{row.key.link, row.key.direction, std::to_string(row.key.id), row.key.name,
          fmt::format("{}/{}", row.key.system, row.key.component),
          old || state.paused ? "-" : fixed(row.hz, 1), age_text(age_s), short_count(row.count)},
         style});
  }
  using Sort = MonitorState::Sort;
  const auto mark = [&](Sort sort, const char* word) {
    return std::string(word) + (state.sort == sort ? "*" : "");
  };
  const TextTable table({{"LINK", 1},
                         {"DIR", 4},
                         {"ID", 7, true},
                         {mark(Sort::kName, "MESSAGE"), 0},
                         {"SYS/CMP", 6, true},
                         {mark(Sort::kRate, "Hz"), 2, true},
                         {mark(Sort::kAge, "AGE"), 3, true},
                         {mark(Sort::kCount, "COUNT"), 5, true}},
                        lines, width);
  const std::size_t room = rows > 1 ? rows - 1 : 0;
  // The selected line stays in the middle once the list is longer than the screen.
  const std::size_t most = shown.size() > room ? shown.size() - room : 0;
  Block block = table.lines(std::min(index > room / 2 ? index - room / 2 : 0, most), rows);
  if (shown.empty()) {
    block.emplace_back(
        state.rows.empty() ? "casd has heard no message yet" : "no message passes the filter",
        Style::kDim);
  }
  return block;
}

Block field_section(const MonitorState& state, double now_s, std::size_t width, std::size_t rows) {
  if (!state.open) {
    Block block{{"NO MESSAGE IS OPEN", Style::kHeader}};
    append(block, wrapped("Enter opens the selected line: its fields with units, their course "
                          "and a plot.",
                          width, Style::kDim));
    return block;
  }
  const std::vector<FieldRow> fields = field_rows(state);
  if (fields.empty()) {
    const auto row = std::find_if(state.rows.begin(), state.rows.end(),
                                  [&](const MessageRow& r) { return r.key == *state.open; });
    const std::string came =
        row == state.rows.end() ? "it has not come yet"
                                : "it came last " + age_text(row->age_s + now_s - state.rows_at_s) +
                                      " ago, before anybody looked; the next one is shown";
    Block block{{state.open->name, Style::kHeader}};
    append(block, wrapped("No values yet: " + came, width, Style::kDim));
    return block;
  }
  const double age_s = state.value.value("age_s", 0.0) + now_s - state.value_at_s;
  const bool is_old = age_s > kStale_s;
  Block block{field_title(state, age_s, is_old, width)};
  constexpr std::size_t kLeastPlot = 6;  // with its title
  const std::size_t table_rows = fields.size() + 1;
  const std::size_t over = rows > 1 + table_rows ? rows - 1 - table_rows : 0;
  const bool is_tight = over < kLeastPlot && rows >= 1 + 4 + kLeastPlot;
  const std::size_t plot_rows = is_tight ? kLeastPlot : over;
  append(block, field_table(state, fields, is_old, width,
                            rows - 1 - (plot_rows >= kLeastPlot ? plot_rows : 0)));
  if (plot_rows >= kLeastPlot) append(block, field_plots(state, fields, now_s, width, plot_rows));
  return block;
}

}  // namespace cas::casctl
