// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cstddef>
#include <numeric>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

// Finds the known word nearest to a misspelt one. Header only: the reader of dialects is built
// before the libraries.

namespace cas::base {

/// How many letters must be changed, added, left out or swapped with their neighbour to turn one
/// word into the other (optimal string alignment).
inline std::size_t edit_distance(std::string_view from, std::string_view to) {
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

/// The known word that was most likely meant: at most a third of its letters differ, or it is the
/// only one that begins so, or lacks no more than a part before or behind an underscore: "z" of
/// "z_m", "share" of "thrust_share". Words of over 64 letters are not compared, and no more than
/// the first 4096 known ones: the cost is bounded whatever is asked.
/// @param known  a range of strings or string views
/// @return empty: none is near
template <class Words>
std::string nearest_word(std::string_view word, const Words& known) {
  constexpr std::size_t kLongest = 64;  // letters
  constexpr std::size_t kMostWords = 4096;
  constexpr std::size_t kLeastBeginning = 3;  // letters that say something
  if (word.empty() || word.size() > kLongest) return {};
  std::string_view nearest;
  std::string_view beginning;
  std::string_view part;
  std::size_t least = 0;
  std::size_t begin_so = 0;
  std::size_t have_part = 0;
  std::size_t seen = 0;
  for (const auto& each_word : known) {
    const std::string_view each(each_word);
    if (++seen > kMostWords) break;
    if (each.starts_with(word)) {
      beginning = each;
      ++begin_so;
    }
    if (each.starts_with(std::string(word) + '_') || each.ends_with('_' + std::string(word))) {
      part = each;
      ++have_part;
    }
    const std::size_t most = std::max<std::size_t>(1, each.size() / 3);
    if (each.size() > kLongest || each.size() > word.size() + most) continue;
    const std::size_t distance = edit_distance(word, each);
    if (distance > most || distance >= each.size()) continue;
    if (!nearest.empty() && distance >= least) continue;
    nearest = each;
    least = distance;
  }
  if (!nearest.empty()) return std::string(nearest);
  if (have_part == 1) return std::string(part);
  const bool says_enough = word.size() >= kLeastBeginning && begin_so == 1;
  return says_enough ? std::string(beginning) : std::string();
}

/// "; did you mean 'status'?", or nothing; neither for a word that is known.
template <class Words>
std::string did_you_mean(std::string_view word, const Words& known) {
  const std::string nearest = nearest_word(word, known);
  return nearest.empty() || nearest == word ? "" : "; did you mean '" + nearest + "'?";
}

}  // namespace cas::base
