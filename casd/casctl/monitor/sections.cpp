// SPDX-License-Identifier: BSD-3-Clause
#include "casd/casctl/monitor/sections.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "casd/casctl/monitor/prompt.hpp"
#include "casd/casctl/monitor/text_table.hpp"
#include "casd/casctl/session/link_counter.hpp"
#include "casd/casctl/session/table.hpp"

namespace cas::casctl {
namespace {

using nlohmann::json;

/// "12", "3.4k", "1.2M": five columns at most.
std::string short_count(std::uint64_t n) {
  const auto value = static_cast<double>(n);
  if (n < 10'000) return std::to_string(n);
  if (n < 1'000'000) return fixed(value / 1e3, n < 100'000 ? 1 : 0) + "k";
  if (n < 1'000'000'000) return fixed(value / 1e6, n < 100'000'000 ? 1 : 0) + "M";
  return fixed(value / 1e9, 1) + "G";
}

std::string number_text(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.6g", value);
  return text;
}

std::string short_number(double value) {
  char text[32];
  std::snprintf(text, sizeof text, std::abs(value) < 1e4 ? "%.3g" : "%.6g", value);
  return text;
}

std::string value_text(const json& value) {
  if (value.is_string()) return value.get<std::string>();
  if (value.is_number_float()) return number_text(value.get<double>());
  if (!value.is_array()) return value.is_null() ? "nan" : value.dump();
  constexpr std::size_t kMost = 4;
  std::string text;
  for (std::size_t i = 0; i < std::min(value.size(), kMost); ++i) {
    text += (text.empty() ? "" : " ") + value_text(value[i]);
  }
  if (value.size() > kMost) text += " and " + std::to_string(value.size() - kMost) + " more";
  return text;
}

/// Without the sign of a zero.
std::string decimal(double value, int decimals) {
  const std::string text = fixed(value, decimals);
  return text.find_first_not_of("-0.") == std::string::npos && text[0] == '-' ? text.substr(1)
                                                                              : text;
}

bool is_stale(const MonitorState& state, double now_s) {
  return !state.casd_fault.empty() || overdue_s(state, state.status_at_s, now_s) > kStale_s;
}

// ---- the open message -------------------------------------------------------------------------

/// A field of the open message with what has been seen of it.
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
  const TextTable table(
      {{"", 1}, {"FIELD", 0}, {"VALUE", 0, true}, {"UNIT", 2}, {"RANGE", 4}, {"COURSE", 3}}, lines,
      width);
  Block block{table.header()};
  const std::size_t room = rows > 1 ? rows - 1 : 0;
  const std::size_t first = state.selected_field < room ? 0 : state.selected_field - room + 1;
  for (std::size_t i = first; i < fields.size() && i < first + room; ++i) {
    block.push_back(table.row(i));
  }
  return block;
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
  ScreenLine line =
      join({{key.name, Style::kHeader},
            {"on " + key.link, Style::kHeader, 2},
            {"from " + std::to_string(key.system) + "/" + std::to_string(key.component),
             Style::kHeader, 3},
            {age_text(age_s) + " old", is_old ? Style::kBad : Style::kHeader, 1},
            {state.paused ? "PAUSED" : "", Style::kBad, 1}},
           width, 1);
  return line;
}

// ---- the vehicle ------------------------------------------------------------------------------

/// A topic of vehicle.telemetry, of which old values are not shown.
class Topic {
 public:
  Topic(const MonitorState& state, const char* name, double now_s) {
    const auto found = state.telemetry.find(name);
    if (found == state.telemetry.end() || !found->is_object()) return;
    if (!found->value("age_s", json()).is_number()) return;
    const auto told_s = found->at("age_s").get<double>();
    age_s_ = told_s + now_s - state.vehicle_at_s;
    if (told_s + overdue_s(state, state.vehicle_at_s, now_s) <= kStale_s) values_ = *found;
  }

  bool is_fresh() const { return !values_.empty(); }
  std::optional<double> number(const char* key) const {
    const auto found = values_.find(key);
    if (found == values_.end() || !found->is_number()) return std::nullopt;
    return found->get<double>();
  }
  /// "-" where it is not known, or old.
  std::string text(const char* key, int decimals) const {
    const auto value = number(key);
    return value ? decimal(*value, decimals) : "-";
  }
  std::string word(const char* key) const {
    const auto found = values_.find(key);
    return found == values_.end() || !found->is_string() ? "-" : found->get<std::string>();
  }
  /// "not heard yet", "12 s old"; empty while it is fresh.
  std::string fault() const {
    if (!age_s_) return "not heard yet";
    return is_fresh() ? "" : age_text(*age_s_) + " old";
  }

 private:
  json values_ = json::object();
  std::optional<double> age_s_;
};

/// "HIL ARMED HOLD in_air".
std::vector<Segment> state_segments(const json& vehicle, const std::string& landed) {
  const bool hil = vehicle.value("hil", false);
  return {{hil ? "HIL" : "NOT HIL", hil ? Style::kPlain : Style::kBad},
          {vehicle.value("armed", false) ? "ARMED" : "disarmed", Style::kPlain},
          {vehicle.value("mode", "?")},
          {landed},
          {vehicle.value("state", ""), Style::kPlain, 2}};
}

std::string state_words(const json& vehicle) {
  std::string text;
  for (const Segment& segment : state_segments(vehicle, vehicle.value("landed", "?"))) {
    if (!segment.text.empty()) text += (text.empty() ? "" : " ") + segment.text;
  }
  return text;
}

/// "links up: sim, gcs; down: fcu".
std::string links_text(const MonitorState& state) {
  std::string up;
  std::string down;
  for (const json& link : state.status.value("links", json::array())) {
    std::string& list = link.value("state", "") == "up" ? up : down;
    list += (list.empty() ? "" : ", ") + link.value("name", "?");
  }
  if (up.empty() && down.empty()) return "casd has no links";
  std::string text = up.empty() ? "no link is up" : "links up: " + up;
  if (!down.empty()) text += "; down: " + down;
  return text;
}

/// Why no values of a vehicle are shown.
std::string absence_text(const MonitorState& state, const Presence& vehicle) {
  switch (vehicle.kind) {
    case Presence::Kind::kUnknown:
      return "casd does not answer since " + age_text(vehicle.age_s) +
             (state.casd_fault.empty() ? "" : ": " + state.casd_fault) +
             "; trying again every second";
    case Presence::Kind::kLost:
      return "Vehicle " + std::to_string(vehicle.summary.value("system", 0)) +
             " is lost: no HEARTBEAT since " + age_text(vehicle.age_s) +
             ". Last heard: " + state_words(vehicle.summary) + "; " + links_text(state) + ".";
    case Presence::Kind::kNone:
      return (state.chosen_vehicle ? "No vehicle " + std::to_string(*state.chosen_vehicle) +
                                         ": no HEARTBEAT of it has come; "
                                   : "No vehicle: no HEARTBEAT of an autopilot has come; ") +
             links_text(state) + ".";
    case Presence::Kind::kHere:
      break;
  }
  return "";
}

/// What speaks against flying, at most `most` lines.
Block complaint_lines(const json& summary, std::size_t width, std::size_t most) {
  Block block;
  const json complaints = summary.value("complaints", json::array());
  for (std::size_t i = 0; i < complaints.size(); ++i) {
    const Block lines = wrapped(complaints[i].is_string() ? complaints[i].get<std::string>() : "",
                                width, Style::kBad, "! ");
    const bool is_last = i + 1 == complaints.size();
    if (block.size() + lines.size() + (is_last ? 0 : 1) > most) {
      const std::string left_out = std::to_string(complaints.size() - i);
      if (block.size() < most) {
        block.emplace_back("! " + left_out + (block.empty() ? "" : " more") +
                               (left_out == "1" ? " complaint" : " complaints") + " (key a)",
                           Style::kBad);
      }
      break;
    }
    append(block, lines);
  }
  return block;
}

struct Reading {
  std::string label, value, unit;
};

/// Readings as one column: "roll   0.41 deg".
Block reading_lines(const std::vector<Reading>& readings) {
  std::size_t label = 0;
  std::size_t value = 0;
  for (const Reading& reading : readings) {
    label = std::max(label, columns(reading.label));
    value = std::max(value, columns(reading.value));
  }
  Block block;
  for (const Reading& reading : readings) {
    block.emplace_back(left(reading.label, label) + " " + right(reading.value, value) + " " +
                       reading.unit);
  }
  return block;
}

/// Columns of readings side by side, as many as have room.
Block side_by_side(const std::vector<Block>& parts, std::size_t width) {
  constexpr std::size_t kGap = 3;
  Block all;
  std::size_t taken = 0;
  for (const Block& part : parts) {
    std::size_t widest = 0;
    for (const ScreenLine& line : part) widest = std::max(widest, columns(line));
    const bool is_first = taken == 0;
    if (!is_first && taken + kGap + widest > width) continue;
    if (all.size() < part.size()) all.resize(part.size());
    for (std::size_t i = 0; i < all.size(); ++i) {
      if (!is_first) all[i] = fit_line(all[i], taken + kGap);
      if (i < part.size()) all[i].add(part[i]);
    }
    taken += widest + (is_first ? 0 : kGap);
  }
  return all;
}

Block vehicle_readings(const MonitorState& state, double now_s, std::size_t width) {
  const Topic attitude(state, "attitude", now_s);
  const Topic position(state, "position", now_s);
  const Topic velocity(state, "velocity", now_s);
  const Topic global(state, "global", now_s);
  const auto titled = [](const char* title, const Topic& topic,
                         const std::vector<Reading>& readings) {
    const std::string fault = topic.fault();
    Block block{{fault.empty() ? title : std::string(title) + " " + fault,
                 fault.empty() ? Style::kDim : Style::kBad}};
    append(block, reading_lines(readings));
    return block;
  };
  constexpr int kPlaceDecimals = 7;  // as on the wire
  return side_by_side({titled("attitude", attitude,
                              {{"roll", attitude.text("roll_deg", 1), "deg"},
                               {"pitch", attitude.text("pitch_deg", 1), "deg"},
                               {"yaw", attitude.text("yaw_deg", 1), "deg"}}),
                       titled("position", position,
                              {{"north", position.text("north_m", 2), "m"},
                               {"east", position.text("east_m", 2), "m"},
                               {"down", position.text("down_m", 2), "m"}}),
                       titled("velocity", velocity,
                              {{"north", velocity.text("north_m_s", 2), "m/s"},
                               {"east", velocity.text("east_m_s", 2), "m/s"},
                               {"down", velocity.text("down_m_s", 2), "m/s"}}),
                       titled("global", global,
                              {{"lat", global.text("lat_deg", kPlaceDecimals), "deg"},
                               {"lon", global.text("lon_deg", kPlaceDecimals), "deg"},
                               {"above sea", global.text("alt_m", 2), "m"},
                               {"above home", global.text("relative_alt_m", 2), "m"}})},
                      width);
}

/// "16.1 V 14.2 A 91 %", "gps 3d 12 satellites".
std::vector<Segment> supply_segments(const MonitorState& state, double now_s) {
  const Topic battery(state, "battery", now_s);
  const Topic gps(state, "gps", now_s);
  std::string supply = battery.text("voltage_v", 1) + " V";
  if (battery.number("current_a")) supply += " " + battery.text("current_a", 1) + " A";
  supply += " " + battery.text("remaining_percent", 0) + " %";
  return {
      {"battery " + (battery.is_fresh() ? supply : battery.fault()),
       battery.is_fresh() ? Style::kPlain : Style::kDim, 1},
      {"GPS " + (gps.is_fresh() ? gps.word("fix") + " " + gps.text("satellites", 0) + " satellites"
                                : gps.fault()),
       gps.is_fresh() ? Style::kPlain : Style::kDim, 2}};
}

/// Horizon with its headings at the left, trail at the right where there is room for both.
Block drawings(const MonitorState& state, double now_s, std::size_t width, std::size_t rows) {
  constexpr std::size_t kLeastRows = 5;
  constexpr std::size_t kLeastWidth = 26;  // of each
  if (rows < kLeastRows) return {};
  const Topic topic(state, "attitude", now_s);
  const Topic position(state, "position", now_s);
  const auto roll = topic.number("roll_deg");
  const auto pitch = topic.number("pitch_deg");
  const auto yaw = topic.number("yaw_deg");
  const bool both = width >= 2 * kLeastWidth + 2 && position.is_fresh();
  const std::size_t first = both ? (width - 2) / 2 : width;
  const std::size_t below = 3;  // headings and a caption
  Block view;
  if (roll && pitch && yaw) {
    view = horizon({*roll, *pitch, *yaw}, first, rows - below, state.unicode);
    append(view, heading_tape(*yaw, first, state.unicode));
    view.emplace_back("heading " + fixed(std::fmod(std::round(*yaw) + 360, 360), 0) +
                          " deg; a line is " + fixed(degrees_a_line(rows - below), 0) + " deg",
                      Style::kDim);
  } else {
    view = wrapped("No horizon: attitude " + topic.fault(), first, Style::kDim);
  }
  view = fit_block(view, rows, first);
  if (!both) return view;
  Block trail = top_view(state.trail, yaw, width - first - 2, rows - 1, state.unicode);
  trail.emplace_back("from above; + is the frame's origin", Style::kDim);
  return beside(view, "  ", fit_block(trail, rows, width - first - 2));
}

Block said_lines(const MonitorState& state, double now_s, std::size_t width, std::size_t rows) {
  const json texts = state.vehicle.value("statustexts", json::array());
  if (rows < 2 || texts.empty()) return {};
  Block newest_first;
  for (std::size_t i = texts.size(); i-- > 0;) {
    const json& text = texts[i];
    const std::string said = text.value("text", "");
    const double age_s = text.value("age_s", 0.0) + now_s - state.vehicle_at_s;
    std::size_t times = 1;  // the same again is said once
    for (; i > 0 && texts[i - 1].value("text", "") == said; --i) ++times;
    const std::string severity = text.value("severity", "");
    const bool is_bad = severity != "info" && severity != "notice" && severity != "debug";
    const std::vector<std::string> lines =
        wrap(said + (times > 1 ? " (" + std::to_string(times) + " times)" : ""),
             width > 11 ? width - 11 : width);
    if (newest_first.size() + lines.size() + 1 > rows) break;
    for (std::size_t j = 0; j < lines.size(); ++j) {
      ScreenLine line(j == 0 ? right(age_text(age_s), 9) + "  " : std::string(11, ' '),
                      Style::kDim);
      newest_first.push_back(line.add(lines[j], is_bad ? Style::kBad : Style::kPlain));
    }
  }
  if (newest_first.empty()) return {};
  Block block{{"WHAT IT SAID, newest first", Style::kHeader}};
  append(block, newest_first);
  return block;
}

}  // namespace

std::string age_text(double age_s) {
  if (age_s < 10) return fixed(std::max(age_s, 0.0), 1) + " s";
  if (age_s < 600) return fixed(age_s, 0) + " s";
  if (age_s < 7200) return fixed(age_s / 60, 0) + " min";
  return fixed(age_s / 3600, 1) + " h";
}

std::string landed_text(const MonitorState& state, const json& summary, double now_s) {
  const json& told = state.vehicle;
  const bool is_its = told.value("system", 0) == summary.value("system", 0);
  if (is_its && told.contains("landed_age_s")) {
    const double age_s = told["landed_age_s"].get<double>();
    if (age_s + overdue_s(state, state.vehicle_at_s, now_s) > kStale_s) {
      return "landed state " + age_text(age_s + now_s - state.vehicle_at_s) + " old";
    }
  }
  return summary.value("landed", "?");
}

Block link_section(const MonitorState& state, double now_s, std::size_t width) {
  const bool old = is_stale(state, now_s);
  std::vector<TextColumn> columns{{"LINK", 0}, {"STATE", 1}, {"RX/s", 2, true}, {"TX/s", 3, true}};
  for (const casd::CounterWords& words : casd::kLinkCounters) {
    if (!words.narrow.empty()) columns.push_back({std::string(words.narrow), words.rank, true});
  }
  columns.push_back({"p99us", 7, true});
  columns.push_back({"ENDPOINT", 9});
  std::vector<TextRow> rows;
  const json links = state.status.value("links", json::array());
  for (const json& link : links) {
    const std::string word = link.value("state", "?");
    const auto rate = state.link_rates.find(link.value("name", "?"));
    const LinkRate rates = rate == state.link_rates.end() ? LinkRate{} : rate->second;
    const auto fresh = [old](const std::string& text) { return old ? std::string("-") : text; };
    std::vector<std::string> cells{link.value("name", "?"), fresh(word),
                                   fresh(fixed(rates.rx_packets_s, 0)),
                                   fresh(fixed(rates.tx_packets_s, 0))};
    for (const casd::CounterWords& words : casd::kLinkCounters) {
      if (!words.narrow.empty()) {
        cells.push_back(fresh(short_count(counter_of(link, words).value_or(0))));
      }
    }
    const json times = link.value("tx", json::object()).value("forwarding_us", json::object());
    cells.push_back(fresh(fixed(times.value("p99", 0.0), 0)));
    cells.push_back(link.value("endpoint", ""));
    const bool losses = counter_of(link, casd::counter_words("rx", "lost")).value_or(0) > 0 ||
                        counter_of(link, casd::counter_words("tx", "dropped")).value_or(0) > 0;
    rows.push_back({std::move(cells), old            ? Style::kDim
                                      : word != "up" ? Style::kBad
                                      : losses       ? Style::kPlain
                                                     : Style::kGood});
  }
  const TextTable table(std::move(columns), std::move(rows), width);
  Block block{table.header()};
  for (std::size_t i = 0; i < table.size(); ++i) {
    block.push_back(table.row(i));
    const bool is_down = !old && links[i].value("state", "") == "down";
    if (is_down && !table.shows("ENDPOINT")) {
      append(block, wrapped(links[i].value("endpoint", ""), width, Style::kBad, "  "));
    }
  }
  if (links.empty()) block.emplace_back("casd has no links", Style::kDim);
  return block;
}

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
          std::to_string(row.key.system) + "/" + std::to_string(row.key.component),
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
  Block block{table.header()};
  const std::size_t room = rows > 1 ? rows - 1 : 0;
  // The selected line stays in the middle once the list is longer than the screen.
  const std::size_t most = shown.size() > room ? shown.size() - room : 0;
  const std::size_t first = std::min(index > room / 2 ? index - room / 2 : 0, most);
  for (std::size_t i = first; i < shown.size() && i < first + room; ++i) {
    block.push_back(table.row(i));
  }
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
  } else if (!state.gains_fault.empty()) {
    append(block, wrapped(state.gains_fault, width, Style::kBad));
  } else if (state.gains_asked_s) {
    block.emplace_back("asked for " + age_text(now_s - *state.gains_asked_s) + " ago", Style::kDim);
  }
  if (lines.empty()) return block;
  const TextTable table({{"LOOP", 0}, {"P", 1, true}, {"I", 2, true}, {"D", 3, true}}, lines,
                        width);
  block.push_back(table.header());
  const std::size_t room = rows > block.size() ? rows - block.size() : 0;
  const std::size_t first = state.selected_gain < room ? 0 : state.selected_gain - room + 1;
  for (std::size_t i = first; i < table.size() && i < first + room; ++i) {
    block.push_back(table.row(i));
  }
  return block;
}

Block vehicle_section(const MonitorState& state, double now_s, std::size_t width,
                      std::size_t rows) {
  const Presence vehicle = presence(state, now_s);
  if (vehicle.kind != Presence::Kind::kHere) {
    Block block{{"VEHICLE", Style::kHeader}};
    append(block, wrapped(absence_text(state, vehicle), width, Style::kBad));
    append(block, said_lines(state, now_s, width, rows - std::min(rows, block.size())));
    return block;
  }
  const json& summary = vehicle.summary;
  Block block{join({{"VEHICLE " + std::to_string(summary.value("system", 0)), Style::kHeader},
                    {summary.value("autopilot", ""), Style::kHeader, 1},
                    {summary.value("type", ""), Style::kHeader, 3},
                    {"on " + summary.value("link", "?"), Style::kHeader, 2}},
                   width, 1)};
  block.push_back(join(state_segments(summary, landed_text(state, summary, now_s)), width));
  append(block, complaint_lines(summary, width, 4));
  append(block, vehicle_readings(state, now_s, width));
  block.push_back(join(supply_segments(state, now_s), width));
  const std::size_t room = rows - std::min(rows, block.size());
  constexpr std::size_t kMostDrawing = 24;
  constexpr std::size_t kSaid = 5;
  const std::size_t drawing = std::min(room > kSaid + 9 ? room - kSaid : room, kMostDrawing);
  append(block, drawings(state, now_s, width, drawing));
  append(block, said_lines(state, now_s, width, rows - std::min(rows, block.size())));
  return block;
}

Block vehicle_summary(const MonitorState& state, double now_s, std::size_t width) {
  const Presence vehicle = presence(state, now_s);
  if (vehicle.kind != Presence::Kind::kHere) {
    return wrapped(absence_text(state, vehicle), width, Style::kBad);
  }
  const Topic attitude(state, "attitude", now_s);
  const Topic position(state, "position", now_s);
  std::vector<Segment> segments{
      {attitude.is_fresh()
           ? "roll " + attitude.text("roll_deg", 1) + "  pitch " + attitude.text("pitch_deg", 1) +
                 "  yaw " + attitude.text("yaw_deg", 1) + " deg"
           : "attitude " + attitude.fault(),
       attitude.is_fresh() ? Style::kPlain : Style::kDim},
      {position.is_fresh()
           ? "N " + position.text("north_m", 2) + "  E " + position.text("east_m", 2) + "  D " +
                 position.text("down_m", 2) + " m"
           : "position " + position.fault(),
       position.is_fresh() ? Style::kPlain : Style::kDim}};
  for (const Segment& segment : supply_segments(state, now_s)) {
    segments.push_back(segment);
    segments.back().rank += 1;
  }
  Block block{join(segments, width, 3)};
  append(block, complaint_lines(vehicle.summary, width, 2));
  return block;
}

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

}  // namespace cas::casctl
