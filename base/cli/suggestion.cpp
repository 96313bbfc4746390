// SPDX-License-Identifier: BSD-3-Clause
#include "base/cli/suggestion.hpp"

#include <algorithm>
#include <numeric>
#include <utility>

namespace cas::base::cli {
namespace {

/// The one word that begins with this; empty: none or several.
std::string only_beginning(const std::string& word, const std::vector<std::string>& known) {
  constexpr std::size_t kLeast = 3;  // letters that say something
  if (word.size() < kLeast) return {};
  std::string only;
  for (const std::string& each : known) {
    if (!each.starts_with(word)) continue;
    if (!only.empty()) return {};
    only = each;
  }
  return only;
}

}  // namespace

std::size_t edit_distance(const std::string& from, const std::string& to) {
  std::vector<std::size_t> before_last;
  std::vector<std::size_t> last(to.size() + 1);
  std::iota(last.begin(), last.end(), std::size_t{0});
  for (std::size_t i = 1; i <= from.size(); ++i) {
    std::vector<std::size_t> row{i};
    for (std::size_t j = 1; j <= to.size(); ++j) {
      const std::size_t change = last[j - 1] + (from[i - 1] == to[j - 1] ? 0 : 1);
      row.push_back(std::min({change, last[j] + 1, row[j - 1] + 1}));
      const bool swapped = i > 1 && j > 1 && from[i - 1] == to[j - 2] && from[i - 2] == to[j - 1];
      if (swapped) row[j] = std::min(row[j], before_last[j - 2] + 1);
    }
    before_last = std::exchange(last, std::move(row));
  }
  return last.back();
}

std::string nearest_word(const std::string& word, const std::vector<std::string>& known) {
  std::string nearest;
  std::size_t least = 0;
  for (const std::string& each : known) {
    const std::size_t distance = edit_distance(word, each);
    const std::size_t most = std::max<std::size_t>(1, each.size() / 3);
    if (distance > most || (!nearest.empty() && distance >= least)) continue;
    nearest = each;
    least = distance;
  }
  return nearest.empty() ? only_beginning(word, known) : nearest;
}

std::string did_you_mean(const std::string& word, const std::vector<std::string>& known) {
  const std::string nearest = nearest_word(word, known);
  return nearest.empty() ? "" : "; did you mean '" + nearest + "'?";
}

}  // namespace cas::base::cli
