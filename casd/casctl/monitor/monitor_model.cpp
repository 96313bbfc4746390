// SPDX-License-Identifier: BSD-3-Clause
#include "casd/casctl/monitor/monitor_model.hpp"

#include <algorithm>
#include <cmath>

namespace cas::casctl {
namespace {

using nlohmann::json;

constexpr double kHistory_s = 120;
constexpr std::size_t kTrail = 600;

std::uint64_t counter(const json& link, const char* way) {
  const auto found = link.find(way);
  return found == link.end() ? 0 : found->value("packets", std::uint64_t{0});
}

std::size_t moved(std::size_t from, int steps, std::size_t count) {
  const int last = std::max(static_cast<int>(count) - 1, 0);
  return static_cast<std::size_t>(std::clamp(static_cast<int>(from) + steps, 0, last));
}

MessageRow row_of(const json& message) {
  MessageRow row;
  row.key = {message.value("link", "?"), message.value("direction", "?"),
             message.value("name", ""),  message.value("id", 0),
             message.value("system", 0), message.value("component", 0)};
  if (row.key.name.empty()) row.key.name = "message " + std::to_string(row.key.id);
  row.hz = message.value("hz", 0.0);
  row.age_s = message.value("age_s", 0.0);
  row.count = message.value("count", std::uint64_t{0});
  return row;
}

json fields_of(const MonitorState& state) {
  const auto found = state.value.find("fields");
  return found != state.value.end() && found->is_array() ? *found : json::array();
}

}  // namespace

void MonitorModel::update(const json& status, const json& messages, double time_s) {
  update_link_rates(status.value("links", json::array()), time_s - state_.status_at_s);
  state_.status_at_s = time_s;
  state_.status = status;
  watch_vehicles(status, messages, time_s);
  if (state_.paused) return;
  state_.rows_at_s = time_s;
  state_.rows.clear();
  for (const json& message : messages) state_.rows.push_back(row_of(message));
  if (!state_.selected && state_.page == Page::kMessages) move(0);
}

void MonitorModel::watch_vehicles(const json& status, const json& messages, double time_s) {
  for (const json& vehicle : status.value("vehicles", json::array())) {
    std::uint64_t count = 0;
    for (const json& message : messages) {
      const bool is_its = message.value("direction", "") == "rx" &&
                          message.value("link", "") == vehicle.value("link", "") &&
                          message.value("system", 0) == vehicle.value("system", 0) &&
                          message.value("component", 0) == vehicle.value("component", 0);
      if (is_its) count += message.value("count", std::uint64_t{0});
    }
    VehicleWatch& watch = state_.watches[vehicle.value("system", 0)];
    // A vehicle whose messages have no place in casd's table is judged by its HEARTBEAT alone.
    if (count == 0 || count != watch.count) watch = {.count = count, .changed_at_s = time_s};
  }
}

void MonitorModel::update_link_rates(const json& links, double seconds) {
  for (const json& link : links) {
    const auto [found, fresh] = state_.link_rates.try_emplace(link.value("name", "?"));
    LinkRate& rate = found->second;
    const std::uint64_t rx = counter(link, "rx");
    const std::uint64_t tx = counter(link, "tx");
    if (!fresh && seconds > 0 && rx >= rate.rx && tx >= rate.tx) {
      rate.rx_packets_s = static_cast<double>(rx - rate.rx) / seconds;
      rate.tx_packets_s = static_cast<double>(tx - rate.tx) / seconds;
    }
    rate.rx = rx;
    rate.tx = tx;
  }
}

void MonitorModel::update_vehicle(const json& vehicle, const json& telemetry, double time_s) {
  const int system = vehicle.value("system", 0);
  if (state_.chosen_vehicle && system != *state_.chosen_vehicle) return;
  if (system != state_.vehicle.value("system", 0)) forget_vehicle();
  state_.vehicle = vehicle;
  state_.telemetry = telemetry;
  state_.vehicle_at_s = time_s;
  const json position = telemetry.value("position", json::object());
  if (!position.contains("north_m") || !position["north_m"].is_number() ||
      !position.value("east_m", json()).is_number() || position.value("age_s", 0.0) > kStale_s) {
    return;
  }
  state_.trail.push_back({position["north_m"].get<double>(), position["east_m"].get<double>()});
  if (state_.trail.size() > kTrail) state_.trail.pop_front();
}

void MonitorModel::update_value(const json& value, double time_s) {
  if (!state_.open || state_.paused || value.value("id", -1) != state_.open->id) return;
  if (!value.contains("fields") || !value["fields"].is_array()) return;
  state_.value = value;
  state_.value_at_s = time_s;
  const double sent_s = time_s - value.value("age_s", 0.0);
  constexpr double kSamePacket_s = 0.02;  // two looks see one packet at almost the same time
  for (const json& field : value["fields"]) {
    const auto number = field.find("value");
    if (number == field.end() || !number->is_number()) continue;
    std::deque<Sample>& history = state_.history[field.value("name", "?")];
    if (!history.empty() && sent_s - history.back().time_s < kSamePacket_s) continue;
    history.push_back({sent_s, number->get<double>()});
    while (time_s - history.front().time_s > kHistory_s) history.pop_front();
  }
  choose_a_field();
}

/// Nothing of one vehicle is shown as another one's.
void MonitorModel::forget_vehicle() {
  state_.vehicle = json::object();
  state_.telemetry = json::object();
  state_.trail.clear();
  state_.gains = json::array();
  state_.gains_fault.reset();
  state_.gains_asked_s.reset();
}

/// The first number that is no time; the user may choose another.
void MonitorModel::choose_a_field() {
  if (state_.is_field_chosen) return;
  const json fields = fields_of(state_);
  for (std::size_t i = 0; i < fields.size(); ++i) {
    const bool is_time = fields[i].value("name", "").starts_with("time");
    if (is_time || !fields[i].value("value", json()).is_number()) continue;
    state_.selected_field = i;
    return;
  }
}

void MonitorModel::update_gains(const json& gains, const std::optional<std::string>& fault,
                                double time_s) {
  state_.gains_asked_s.reset();
  state_.gains_fault = fault;
  if (fault) return;
  state_.gains = gains;
  state_.gains_at_s = time_s;
}

void MonitorModel::move(int steps) {
  if (state_.page == Page::kHelp) {
    constexpr std::size_t kLongestHelp = 100;  // the view stops at its end
    state_.help_top = moved(state_.help_top, steps, kLongestHelp);
    return;
  }
  if (state_.page == Page::kGains) {
    state_.selected_gain = moved(state_.selected_gain, steps, state_.gains.size());
    return;
  }
  const std::vector<MessageRow> shown = visible_rows(state_);
  if (shown.empty()) return state_.selected.reset();
  const auto at = std::find_if(shown.begin(), shown.end(), [this](const MessageRow& row) {
    return state_.selected == row.key;
  });
  const std::size_t index = at == shown.end() ? 0 : static_cast<std::size_t>(at - shown.begin());
  state_.selected = shown[moved(index, steps, shown.size())].key;
}

void MonitorModel::move_field(int steps) {
  state_.selected_field = moved(state_.selected_field, steps, fields_of(state_).size());
  state_.is_field_chosen = true;
}

void MonitorModel::cycle_sort() {
  state_.sort = static_cast<MonitorState::Sort>((static_cast<int>(state_.sort) + 1) % 4);
}

void MonitorModel::cycle_link() {
  std::vector<std::string> names{""};
  for (const json& link : state_.status.value("links", json::array())) {
    names.push_back(link.value("name", "?"));
  }
  const auto at = std::find(names.begin(), names.end(), state_.link);
  state_.link = at == names.end() || at + 1 == names.end() ? "" : *(at + 1);
  move(0);
}

void MonitorModel::cycle_direction() {
  std::string& direction = state_.direction;
  direction = direction.empty() ? "rx" : direction == "rx" ? "tx" : direction == "tx" ? "drop" : "";
  move(0);
}

void MonitorModel::cycle_vehicle() {
  const json vehicles = state_.status.value("vehicles", json::array());
  if (vehicles.size() < 2) return set_note("casd hears no other vehicle", false);
  std::size_t next = 1;
  for (std::size_t i = 0; i < vehicles.size(); ++i) {
    if (vehicles[i].value("system", 0) == state_.chosen_vehicle) next = (i + 1) % vehicles.size();
  }
  state_.chosen_vehicle = vehicles[next].value("system", 0);
  forget_vehicle();
}

void MonitorModel::set_filter(const std::string& filter) {
  state_.filter = filter;
  move(0);
}

void MonitorModel::close() {
  state_.value = json::object();
  state_.history.clear();
  state_.is_field_chosen = false;
  state_.selected_field = 0;
  state_.open.reset();
}

void MonitorModel::toggle_open() {
  const bool is_other = state_.open != state_.selected;
  close();
  if (!is_other || !state_.selected) return;
  if (state_.selected->direction != "rx") {
    return set_note("values are shown of received messages; pick a line with direction rx", true);
  }
  state_.open = state_.selected;
}

void MonitorModel::show(Page page) {
  state_.page = state_.page == page ? Page::kMessages : page;
  state_.help_top = 0;
}

void MonitorModel::set_note(const std::string& note, bool bad) {
  state_.note = note;
  state_.note_bad = bad;
}

void MonitorModel::set_answer(const std::string& answer, bool bad, double time_s) {
  state_.answer_at_s = time_s;
  state_.answer = answer;
  state_.answer_bad = bad;
}

void MonitorModel::set_prompt(std::optional<std::string> prompt, const std::string& hint) {
  state_.prompt = std::move(prompt);
  state_.hint = hint;
}

std::optional<json> MonitorModel::selected_gain() const {
  if (state_.page != Page::kGains || state_.selected_gain >= state_.gains.size()) {
    return std::nullopt;
  }
  return state_.gains[state_.selected_gain];
}

}  // namespace cas::casctl
