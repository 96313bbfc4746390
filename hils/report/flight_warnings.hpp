// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <string>
#include <utility>
#include <vector>

namespace cas::hils {

/// Warnings of several flights: each sentence once, with the number of flights that had it.
class FlightWarnings {
 public:
  /// Adds the warnings of one flight.
  void add(const std::vector<std::string>& warnings);

  /// Number of flights that were added.
  std::size_t flights() const { return flights_; }
  /// Sentences and numbers of flights, in the order in which they were first met.
  const std::vector<std::pair<std::string, std::size_t>>& all() const { return all_; }
  /// "warning in 3 of 24 flights: ...", the most frequent first. After twenty the last sentence
  /// says how many more there are.
  std::vector<std::string> sentences() const;

 private:
  std::size_t flights_ = 0;
  std::vector<std::pair<std::string, std::size_t>> all_;
};

/// The warnings as a list of {warning, flights}. @tparam Json  a type of nlohmann::basic_json
template <class Json>
Json warnings_json(const FlightWarnings& warnings) {
  Json list = Json::array();
  for (const auto& [sentence, flights] : warnings.all()) {
    list.push_back({{"warning", sentence}, {"flights", flights}});
  }
  return list;
}

}  // namespace cas::hils
