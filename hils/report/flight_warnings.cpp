// SPDX-License-Identifier: BSD-3-Clause
#include "hils/report/flight_warnings.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <set>

namespace cas::hils {

namespace {
using Counted = std::pair<std::string, std::size_t>;
constexpr std::size_t kMostSentences = 20;
}  // namespace

void FlightWarnings::add(const std::vector<std::string>& warnings) {
  ++flights_;
  for (const std::string& sentence : std::set(warnings.begin(), warnings.end())) {
    const auto known = std::ranges::find(all_, sentence, &Counted::first);
    if (known == all_.end()) {
      all_.emplace_back(sentence, 1);
    } else {
      ++known->second;
    }
  }
}

std::vector<std::string> FlightWarnings::sentences() const {
  std::vector<Counted> sorted = all_;
  std::ranges::stable_sort(sorted, std::greater(), &Counted::second);
  std::vector<std::string> sentences;
  for (const auto& [sentence, flights] : sorted) {
    if (sentences.size() == kMostSentences) {
      sentences.push_back(
          fmt::format("further warnings, not shown: {}", sorted.size() - kMostSentences));
      break;
    }
    sentences.push_back(
        fmt::format("warning in {} of {} flights: {}", flights, flights_, sentence));
  }
  return sentences;
}

}  // namespace cas::hils
