// SPDX-License-Identifier: BSD-3-Clause
#include "casd/casctl/monitor/monitor_model.hpp"

#include <algorithm>
#include <cctype>

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

}  // namespace cas::casctl
