// SPDX-License-Identifier: BSD-3-Clause
#include "casd/casctl/monitor/monitor_model.hpp"

#include <algorithm>
#include <cctype>
#include <cmath>

#include "casd/casctl/session/table.hpp"

namespace cas::casctl {
namespace {

using nlohmann::json;

constexpr std::size_t kHistory = 60;

std::string lower(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return text;
}

std::uint64_t counter(const json& link, const char* way) {
  const auto found = link.find(way);
  return found == link.end() ? 0 : found->value("packets", std::uint64_t{0});
}

constexpr std::size_t kMinRows = 8;

std::uint64_t sum(const json& counters) {
  std::uint64_t total = 0;
  for (const auto& item : counters.items()) {
    if (item.value().is_number()) total += item.value().get<std::uint64_t>();
  }
  return total;
}

std::string right(const std::string& text, std::size_t width) {
  return text.size() >= width ? text : std::string(width - text.size(), ' ') + text;
}

std::string left(const std::string& text, std::size_t width) { return fit(text, width); }

/// "12", "3.4k", "1.2M": five columns at most.
std::string short_count(std::uint64_t n) {
  const auto value = static_cast<double>(n);
  if (n < 10'000) return std::to_string(n);
  if (n < 1'000'000) return fixed(value / 1e3, n < 100'000 ? 1 : 0) + "k";
  if (n < 1'000'000'000) return fixed(value / 1e6, n < 100'000'000 ? 1 : 0) + "M";
  return fixed(value / 1e9, 1) + "G";
}

std::string age_text(double age_s) {
  if (age_s < 10) return fixed(age_s, 1) + "s";
  if (age_s < 600) return fixed(age_s, 0) + "s";
  return fixed(age_s / 60, 0) + "m";
}

std::string value_text(const json& value) {
  if (value.is_string()) return value.get<std::string>();
  if (value.is_number_float()) {
    char text[32];
    std::snprintf(text, sizeof text, "%.6g", value.get<double>());
    return text;
  }
  if (value.is_array()) {
    std::string text;
    for (const json& item : value) text += (text.empty() ? "" : " ") + value_text(item);
    return text;
  }
  return value.is_null() ? "nan" : value.dump();
}

void append(std::vector<ScreenLine>& to, std::vector<ScreenLine> from) {
  for (ScreenLine& line : from) to.push_back(std::move(line));
}

}  // namespace

std::size_t columns(const std::string& text) {
  return static_cast<std::size_t>(std::count_if(text.begin(), text.end(), [](char c) {
    return (static_cast<unsigned char>(c) & 0xC0U) != 0x80U;  // continuation bytes take no column
  }));
}

std::string fit(const std::string& text, std::size_t width) {
  std::size_t taken = 0;
  std::size_t end = 0;
  for (; end < text.size(); ++end) {
    if ((static_cast<unsigned char>(text[end]) & 0xC0U) == 0x80U) continue;
    if (taken == width) break;
    ++taken;
  }
  return text.substr(0, end) + std::string(width - taken, ' ');
}

void MonitorModel::update(const json& status, const json& messages, double time_s) {
  update_link_rates(status.value("links", json::array()), time_s - updated_s_);
  updated_s_ = time_s;
  status_ = status;
  rows_.clear();
  for (const json& message : messages) {
    Row row;
    row.key = {message.value("link", "?"), message.value("direction", "?"),
               message.value("name", ""),  message.value("id", 0),
               message.value("system", 0), message.value("component", 0)};
    if (row.key.name.empty()) row.key.name = "message " + std::to_string(row.key.id);
    row.hz = message.value("hz", 0.0);
    row.age_s = message.value("age_s", 0.0);
    row.count = message.value("count", std::uint64_t{0});
    rows_.push_back(std::move(row));
  }
  if (!selected_) move(0);
}

void MonitorModel::update_link_rates(const json& links, double seconds) {
  for (const json& link : links) {
    const auto [found, fresh] = link_rates_.try_emplace(link.value("name", "?"));
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

void MonitorModel::update_value(const json& value) {
  if (!open_ || value.value("id", -1) != open_->id) return;
  const json fields = value.value("fields", json());
  if (!fields.is_array()) return;
  value_ = value;
  for (const json& field : fields) {
    const auto number = field.find("value");
    if (number == field.end() || !number->is_number()) continue;
    std::deque<double>& history = history_[field.value("name", "?")];
    history.push_back(number->get<double>());
    if (history.size() > kHistory) history.pop_front();
  }
}

/// The rows that filters leave, in order.
std::vector<MonitorModel::Row> MonitorModel::visible() const {
  std::vector<Row> shown;
  const std::string wanted = lower(filter_);
  for (const Row& row : rows_) {
    if (!link_.empty() && row.key.link != link_) continue;
    if (!direction_.empty() && row.key.direction.rfind(direction_, 0) != 0) continue;
    if (lower(row.key.name).find(wanted) == std::string::npos) continue;
    shown.push_back(row);
  }
  std::stable_sort(shown.begin(), shown.end(), [this](const Row& a, const Row& b) {
    if (sort_ == Sort::kRate && a.hz != b.hz) return a.hz > b.hz;
    if (sort_ == Sort::kAge && a.age_s != b.age_s) return a.age_s < b.age_s;
    if (sort_ == Sort::kCount && a.count != b.count) return a.count > b.count;
    return a.key < b.key;
  });
  return shown;
}

void MonitorModel::move(int steps) {
  if (page_ == Page::kGains) {
    const auto last = static_cast<int>(gains_.size()) - 1;
    selected_gain_ = static_cast<std::size_t>(
        std::clamp(static_cast<int>(selected_gain_) + steps, 0, std::max(last, 0)));
    return;
  }
  const std::vector<Row> shown = visible();
  if (shown.empty()) return selected_.reset();
  const auto at = std::find_if(shown.begin(), shown.end(),
                               [this](const Row& row) { return selected_ == row.key; });
  const auto index = at == shown.end() ? 0 : static_cast<int>(at - shown.begin());
  const int last = static_cast<int>(shown.size()) - 1;
  selected_ = shown[static_cast<std::size_t>(std::clamp(index + steps, 0, last))].key;
}

void MonitorModel::cycle_sort() { sort_ = static_cast<Sort>((static_cast<int>(sort_) + 1) % 4); }

void MonitorModel::cycle_link() {
  const json links = status_.value("links", json::array());
  std::vector<std::string> names{""};
  for (const json& link : links) names.push_back(link.value("name", "?"));
  const auto at = std::find(names.begin(), names.end(), link_);
  link_ = at == names.end() || at + 1 == names.end() ? "" : *(at + 1);
  move(0);
}

void MonitorModel::cycle_direction() {
  direction_ = direction_.empty()   ? "rx"
               : direction_ == "rx" ? "tx"
               : direction_ == "tx" ? "drop"
                                    : "";
  move(0);
}

void MonitorModel::set_filter(const std::string& filter) {
  filter_ = filter;
  move(0);
}

void MonitorModel::toggle_open() {
  value_ = json::object();
  history_.clear();
  if (open_ || !selected_) {
    open_.reset();
  } else if (selected_->direction != "rx") {
    set_note("values are shown of received messages; pick a line with direction rx", true);
  } else {
    open_ = selected_;
  }
}

void MonitorModel::set_note(const std::string& note, bool bad) {
  note_ = note;
  note_bad_ = bad;
}

std::optional<json> MonitorModel::selected_gain() const {
  if (page_ != Page::kGains || selected_gain_ >= gains_.size()) return std::nullopt;
  return gains_[selected_gain_];
}

std::vector<ScreenLine> MonitorModel::render(std::size_t rows, std::size_t width) const {
  std::vector<ScreenLine> screen{{title(), Style::kTitle}};
  if (rows < kMinRows) rows = kMinRows;
  append(screen, link_lines(width, rows / 3));
  const std::size_t below = 2;  // status text, prompt
  const std::size_t middle = rows - std::min(rows, screen.size() + below);
  if (page_ == Page::kHelp) {
    append(screen, help_lines());
  } else if (page_ == Page::kGains) {
    append(screen, gain_lines(middle, width));
  } else if (open_) {
    const std::size_t fields = middle * 3 / 5;
    append(screen, message_lines(middle - fields, width));
    append(screen, field_lines(fields, width));
  } else {
    append(screen, message_lines(middle, width));
  }
  screen.resize(rows - below);
  const json texts = vehicle_.value("statustexts", json::array());
  std::string newest;
  if (!texts.empty()) {
    newest = age_text(texts.back().value("age_s", 0.0)) + " ago  " + texts.back().value("text", "");
  }
  screen.push_back({newest, Style::kDim});
  screen.push_back(last_line(width));
  for (ScreenLine& line : screen) line.text = fit(line.text, width);
  return screen;
}

std::string MonitorModel::title() const {
  std::string text = "casd " + status_.value("version", "?") + "  up " +
                     duration_text(status_.value("uptime_s", 0.0)) + "  " +
                     status_.value("threads", "?");
  const json vehicles = status_.value("vehicles", json::array());
  for (const json& vehicle : vehicles) {
    text += "  |  " + vehicle.value("system", json(0)).dump() + " " +
            vehicle.value("autopilot", "?") +
            (vehicle.value("hil", false) ? " HIL " : " NOT HIL ") +
            (vehicle.value("armed", false) ? "ARMED " : "disarmed ") + vehicle.value("mode", "?") +
            " " + vehicle.value("landed", "?");
  }
  if (vehicles.empty()) text += "  |  no vehicle heard";
  if (vehicle_.contains("altitude_m")) text += " " + fixed(vehicle_["altitude_m"], 2) + " m";
  return text;
}

std::vector<ScreenLine> MonitorModel::link_lines(std::size_t width, std::size_t most) const {
  std::vector<ScreenLine> lines{{left("LINK", 10) + left("STATE", 8) + right("RX/s", 7) +
                                     right("TX/s", 7) + right("LOST", 7) + right("CRC", 6) +
                                     right("DROP", 7) + right("QMAX", 6) + right("p99us", 8) +
                                     (width >= 100 ? "  ENDPOINT" : ""),
                                 Style::kHeader}};
  for (const json& link : status_.value("links", json::array())) {
    if (lines.size() >= most) break;
    const std::string name = link.value("name", "?");
    const json rx = link.value("rx", json::object());
    const json tx = link.value("tx", json::object());
    const json forwarding = tx.value("forwarding_us", json::object());
    const auto rate = link_rates_.find(name);
    const LinkRate rates = rate == link_rates_.end() ? LinkRate{} : rate->second;
    const std::string state = link.value("state", "?");
    const std::uint64_t lost = rx.value("lost", std::uint64_t{0});
    const std::uint64_t dropped = sum(tx.value("dropped", json::object()));
    lines.push_back({left(name, 9) + " " + left(state, 8) + right(fixed(rates.rx_packets_s, 0), 7) +
                         right(fixed(rates.tx_packets_s, 0), 7) + right(short_count(lost), 7) +
                         right(short_count(rx.value("crc_errors", std::uint64_t{0})), 6) +
                         right(short_count(dropped), 7) +
                         right(short_count(tx.value("queue_high_water", std::uint64_t{0})), 6) +
                         right(fixed(forwarding.value("p99", 0.0), 0), 8) +
                         (width >= 100 ? "  " + link.value("endpoint", "") : ""),
                     state != "up"             ? Style::kBad
                     : lost > 0 || dropped > 0 ? Style::kPlain
                                               : Style::kGood});
  }
  return lines;
}

std::vector<ScreenLine> MonitorModel::message_lines(std::size_t rows, std::size_t width) const {
  constexpr std::size_t kFixed = 10 + 10 + 8 + 8 + 8 + 8 + 7;
  const std::size_t name_width =
      width > kFixed + 12 ? std::min<std::size_t>(width - kFixed, 40) : 12;
  const auto mark = [this](Sort sort, const char* word) {
    return std::string(word) + (sort_ == sort ? "*" : "");
  };
  std::vector<ScreenLine> lines{{left("LINK", 10) + left("DIR", 10) + right("ID", 6) + "  " +
                                     left(mark(Sort::kName, "MESSAGE"), name_width) +
                                     right("SYS/CMP", 8) + right(mark(Sort::kRate, "Hz"), 8) +
                                     right(mark(Sort::kAge, "AGE"), 8) +
                                     right(mark(Sort::kCount, "COUNT"), 7),
                                 Style::kHeader}};
  const std::vector<Row> shown = visible();
  const auto at = std::find_if(shown.begin(), shown.end(),
                               [this](const Row& row) { return selected_ == row.key; });
  const auto index = static_cast<std::size_t>(at == shown.end() ? 0 : at - shown.begin());
  const std::size_t room = rows > 1 ? rows - 1 : 0;
  const std::size_t first = index < room ? 0 : index - room + 1;
  for (std::size_t i = first; i < shown.size() && i < first + room; ++i) {
    const Row& row = shown[i];
    constexpr double kOld = 3;  // seconds
    lines.push_back(
        {left(row.key.link, 9) + " " + left(row.key.direction, 10) +
             right(std::to_string(row.key.id), 6) + "  " + left(row.key.name, name_width) +
             right(std::to_string(row.key.system) + "/" + std::to_string(row.key.component), 8) +
             right(fixed(row.hz, 1), 8) + right(age_text(row.age_s), 8) +
             right(short_count(row.count), 7),
         selected_ == row.key ? Style::kSelected
         : row.age_s > kOld   ? Style::kDim
                              : Style::kPlain});
  }
  if (shown.empty()) lines.push_back({"no message passes the filter", Style::kDim});
  return lines;
}

std::vector<ScreenLine> MonitorModel::field_lines(std::size_t rows, std::size_t width) const {
  std::vector<ScreenLine> lines;
  const json fields = value_.value("fields", json());
  lines.push_back({open_->name + " on " + open_->link + " from " + std::to_string(open_->system) +
                       "/" + std::to_string(open_->component),
                   Style::kHeader});
  if (!fields.is_array()) {
    lines.push_back({"waiting for the next packet", Style::kDim});
    return lines;
  }
  for (const json& field : fields) {
    if (lines.size() >= rows) break;
    const std::string name = field.value("name", "?");
    const auto history = history_.find(name);
    std::string text = left(name, 20) + " " + left(value_text(field.value("value", json())), 16) +
                       " " + left(field.value("units", ""), 7);
    if (history != history_.end() && width > 50) text += " " + sparkline(history->second);
    lines.push_back({text, Style::kPlain});
  }
  return lines;
}

std::string MonitorModel::sparkline(const std::deque<double>& history) const {
  constexpr const char* kBlocks[] = {"▁", "▂", "▃", "▄", "▅", "▆", "▇", "█"};
  constexpr const char* kAscii[] = {"_", ".", "-", "~", "=", "+", "*", "#"};
  constexpr std::size_t kWidth = 30;
  const std::size_t first = history.size() > kWidth ? history.size() - kWidth : 0;
  const auto [low, high] =
      std::minmax_element(history.begin() + static_cast<std::ptrdiff_t>(first), history.end());
  std::string text;
  for (std::size_t i = first; i < history.size(); ++i) {
    const double span = *high - *low;
    const double part = span > 0 && std::isfinite(span) ? (history[i] - *low) / span : 0;
    const auto step = static_cast<std::size_t>(std::lround(part * 7));
    text += unicode_ ? kBlocks[step] : kAscii[step];
  }
  return text;
}

std::vector<ScreenLine> MonitorModel::gain_lines(std::size_t rows, std::size_t) const {
  std::vector<ScreenLine> lines{
      {left("LOOP", 14) + right("P", 12) + right("I", 12) + right("D", 12), Style::kHeader}};
  const auto cell = [](const json& gains, const char* key) {
    return right(gains.contains(key) ? value_text(gains[key]) : "-", 12);
  };
  for (std::size_t i = 0; i < gains_.size() && lines.size() < rows; ++i) {
    const json& gains = gains_[i];
    lines.push_back({left(gains.value("loop", "?"), 14) + cell(gains, "p") + cell(gains, "i") +
                         cell(gains, "d"),
                     i == selected_gain_ ? Style::kSelected : Style::kPlain});
  }
  if (gains_.empty()) lines.push_back({"reading the gains of the vehicle", Style::kDim});
  return lines;
}

std::vector<ScreenLine> MonitorModel::help_lines() const {
  std::vector<ScreenLine> lines{{"KEYS", Style::kHeader}};
  for (const char* text :
       {"up, down, PgUp, PgDn   select a message (or a loop)",
        "Enter                  open the message: its fields and their course",
        "Tab                    next link, then all",
        "d                      received, sent, dropped, all",
        "s                      sort by name, rate, age, count",
        "/                      filter by name", "p                      pause",
        "g                      gains; Enter there edits P I D of the loop",
        ":                      command: arm, disarm, takeoff 2.5, land, hold, rtl, mode HOLD,",
        "                       goto 5 0 -3 90, setgain roll 6.5, message-interval ATTITUDE 20",
        "q                      quit"}) {
    lines.push_back({text, Style::kPlain});
  }
  return lines;
}

ScreenLine MonitorModel::last_line(std::size_t) const {
  if (prompt_) return {*prompt_, Style::kPlain};
  if (!note_.empty()) return {note_, note_bad_ ? Style::kBad : Style::kGood};
  std::string keys = "q quit  Enter open  Tab link  d dir  s sort  / filter  g gains  : do  ? keys";
  if (paused_) keys = "PAUSED (p goes on)  " + keys;
  if (!link_.empty() || !direction_.empty() || !filter_.empty()) {
    keys = "[" + (link_.empty() ? std::string("all") : link_) +
           (direction_.empty() ? "" : " " + direction_) + (filter_.empty() ? "" : " /" + filter_) +
           "]  " + keys;
  }
  return {keys, Style::kDim};
}

}  // namespace cas::casctl
