// SPDX-License-Identifier: BSD-3-Clause
#include "casd/casctl/monitor/sections.hpp"

#include <utility>

#include "casd/casctl/monitor/text_table.hpp"
#include "casd/casctl/session/text.hpp"

namespace cas::casctl {
namespace {

using nlohmann::json;

std::vector<TextColumn> link_columns() {
  std::vector<TextColumn> columns{{"LINK", 0}, {"STATE", 1}, {"RX/s", 2, true}, {"TX/s", 3, true}};
  for (const casd::CounterWords& words : casd::kLinkCounters) {
    if (!words.narrow.empty()) columns.push_back({std::string(words.narrow), words.rank, true});
  }
  columns.push_back({"p99us", 7, true});
  columns.push_back({"ENDPOINT", 9});
  return columns;
}

TextRow link_row(const json& link, const LinkRate& rates, bool old) {
  const auto fresh = [old](const std::string& text) { return old ? std::string("-") : text; };
  const std::string word = link.value("state", "?");
  std::vector<std::string> cells{link.value("name", "?"), fresh(word),
                                 fresh(fixed(rates.rx_packets_s, 0)),
                                 fresh(fixed(rates.tx_packets_s, 0))};
  for (const casd::CounterWords& words : casd::kLinkCounters) {
    if (words.narrow.empty()) continue;
    cells.push_back(fresh(short_count(counter_of(link, words).value_or(0))));
  }
  const json times = link.value("tx", json::object()).value("forwarding_us", json::object());
  cells.push_back(fresh(fixed(times.value("p99", 0.0), 0)));
  cells.push_back(endpoint_text(link));
  const bool losses = counter_of(link, casd::counter_words("rx", "lost")).value_or(0) > 0 ||
                      counter_of(link, casd::counter_words("tx", "dropped")).value_or(0) > 0;
  return {std::move(cells), old            ? Style::kDim
                            : word != "up" ? Style::kBad
                            : losses       ? Style::kPlain
                                           : Style::kGood};
}

}  // namespace

Block link_section(const MonitorState& state, double now_s, std::size_t width) {
  const bool old = is_stale(state, now_s);
  const json links = state.status.value("links", json::array());
  std::vector<TextRow> rows;
  for (const json& link : links) {
    const auto rates = state.link_rates.find(link.value("name", "?"));
    rows.push_back(
        link_row(link, rates == state.link_rates.end() ? LinkRate{} : rates->second, old));
  }
  const TextTable table(link_columns(), std::move(rows), width);
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

}  // namespace cas::casctl
