// SPDX-License-Identifier: BSD-3-Clause
#include "casd/casctl/monitor/sections.hpp"

#include <fmt/format.h>
#include <algorithm>
#include <cmath>

#include "casd/casctl/session/text.hpp"

namespace cas::casctl {
namespace {

using nlohmann::json;

/// Without the sign of a zero.
std::string decimal(double value, int decimals) {
  const std::string text = fixed(value, decimals);
  return text.find_first_not_of("-0.") == std::string::npos && text[0] == '-' ? text.substr(1)
                                                                              : text;
}

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
             (state.casd_fault ? ": " + *state.casd_fault : "") + "; trying again every second";
    case Presence::Kind::kLost:
      return fmt::format("Vehicle {} is lost: no HEARTBEAT since {}. Last heard: {}; {}.",
                         vehicle.summary.value("system", 0), age_text(vehicle.age_s),
                         state_words(vehicle.summary), links_text(state));
    case Presence::Kind::kNone:
      return (state.chosen_vehicle ? fmt::format("No vehicle {}: no HEARTBEAT of it has come; ",
                                                 *state.chosen_vehicle)
                                   : "No vehicle: no HEARTBEAT of an autopilot has come; ") +
             links_text(state) + ".";
    case Presence::Kind::kHere:
      break;
  }
  return "";
}

/// Reasons not to fly, at most `most` lines.
Block complaint_lines(const json& summary, std::size_t width, std::size_t most) {
  Block block;
  const json complaints = summary.value("complaints", json::array());
  for (std::size_t i = 0; i < complaints.size(); ++i) {
    const Block lines = wrapped(complaints[i].is_string() ? complaints[i].get<std::string>() : "",
                                width, Style::kBad, "! ");
    const bool is_last = i + 1 == complaints.size();
    if (block.size() + lines.size() + (is_last ? 0 : 1) > most) {
      const std::size_t left_out = complaints.size() - i;
      if (block.size() < most) {
        block.emplace_back(fmt::format("! {}{} complaint{} (key a)", left_out,
                                       block.empty() ? "" : " more", left_out == 1 ? "" : "s"),
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
        wrap(said + (times > 1 ? fmt::format(" ({} times)", times) : ""),
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
  Block block{join({{fmt::format("VEHICLE {}", summary.value("system", 0)), Style::kHeader},
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

}  // namespace cas::casctl
