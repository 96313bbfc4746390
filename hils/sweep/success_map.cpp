// SPDX-License-Identifier: BSD-3-Clause
#include "hils/sweep/success_map.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <set>

namespace cas::hils {

namespace {

std::optional<double> number_of(const std::string& text) {
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{} || end != text.data() + text.size()) return std::nullopt;
  return value;
}

/// The bin of each row by the place of its value among those that there are.
Bins by_value(const std::string& name, const std::vector<std::string>& values,
              std::vector<std::string> distinct) {
  Bins bins{.name = name, .labels = std::move(distinct), .bin_of = {}};
  for (const std::string& value : values) {
    const auto at = std::ranges::find(bins.labels, value);
    bins.bin_of.push_back(static_cast<std::size_t>(at - bins.labels.begin()));
  }
  return bins;
}

/// An end of a bin in three digits, without a power of ten where it is a few thousand.
std::string end_text(double value) {
  const double size = std::abs(value);
  return size >= 1000 && size < 1e6 ? fmt::format("{:.0f}", value) : fmt::format("{:.3g}", value);
}

}  // namespace

Bins Bins::of(const std::string& name, const std::vector<std::string>& values, bool log,
              std::size_t most) {
  std::vector<std::string> distinct;
  std::set<std::string> seen;
  bool numbers = true;
  for (const std::string& value : values) {
    if (!seen.insert(value).second) continue;
    distinct.push_back(value);
    numbers = numbers && number_of(value);
  }
  if (numbers) {
    std::ranges::sort(distinct, {}, [](const std::string& text) { return *number_of(text); });
  }
  if (!numbers || distinct.size() <= most) return by_value(name, values, std::move(distinct));

  log = log && *number_of(distinct.front()) > 0;  // a drawn value may have been rounded to 0
  const auto scale = [log](double value) { return log ? std::log(value) : value; };
  const double low = scale(*number_of(distinct.front()));
  const double width = (scale(*number_of(distinct.back())) - low) / static_cast<double>(most);
  Bins bins{.name = name, .labels = {}, .bin_of = {}};
  for (std::size_t i = 0; i < most; ++i) {
    const auto end = [&](std::size_t at) {
      const double value = low + width * static_cast<double>(at);
      return log ? std::exp(value) : value;
    };
    bins.labels.push_back(end_text(end(i)) + ".." + end_text(end(i + 1)));
  }
  for (const std::string& value : values) {
    const double at = (scale(*number_of(value)) - low) / width;
    bins.bin_of.push_back(std::min(static_cast<std::size_t>(std::max(at, 0.0)), most - 1));
  }
  return bins;
}

int ShareCell::side() const {
  if (trials == 0) return 0;
  const ShareInterval range = interval();
  if (range.low > 0.5) return 1;
  return range.high < 0.5 ? -1 : 0;
}

std::vector<ShareCell> count_by(const Bins& bins, const std::vector<std::optional<bool>>& success) {
  std::vector<ShareCell> cells(bins.labels.size());
  for (std::size_t row = 0; row < success.size(); ++row) {
    if (!success[row]) continue;
    ShareCell& cell = cells[bins.bin_of[row]];
    ++cell.trials;
    if (*success[row]) ++cell.successes;
  }
  return cells;
}

std::vector<ShareCell> count_by(const Bins& x, const Bins& y,
                                const std::vector<std::optional<bool>>& success) {
  Bins both{.name = {}, .labels = {}, .bin_of = {}};
  both.labels.resize(x.labels.size() * y.labels.size());
  for (std::size_t row = 0; row < success.size(); ++row) {
    both.bin_of.push_back(y.bin_of[row] * x.labels.size() + x.bin_of[row]);
  }
  return count_by(both, success);
}

Document::Table success_map(const Bins& x, const Bins& y, const std::vector<ShareCell>& cells) {
  Document::Table map{fmt::format("Stays up, %: {} over {}", y.name, x.name), {{y.name}}};
  for (const std::string& label : x.labels) map.rows.front().push_back(label);
  for (std::size_t j = y.labels.size(); j-- > 0;) {
    Row& row = map.rows.emplace_back(Row{y.labels[j]});
    for (std::size_t i = 0; i < x.labels.size(); ++i) {
      const ShareCell& here = cells[j * x.labels.size() + i];
      Cell& cell = row.emplace_back("");
      if (here.trials == 0) continue;
      cell.text = fmt::format("{:.0f}{}", here.share() * 100, here.side() == 0 ? " ?" : "");
      cell.detail = fmt::format("{} of {}", here.successes, here.trials);
      cell.share = here.share();
      cell.framed = here.side() == 1;
    }
  }
  return map;
}

}  // namespace cas::hils
