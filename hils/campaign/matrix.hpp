// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "hils/campaign/campaign.hpp"
#include "hils/sweep/row_result.hpp"

namespace cas::hils {

/// One flight of a campaign, judged by its expectation.
struct CampaignFlight {
  std::size_t row = 0;  ///< of the sweep, from 1
  std::uint64_t seed = 1;
  std::optional<StrikeResponse> response{};  ///< nullopt: no verdict
  std::vector<std::string> misses{};         ///< sentences; none: all as expected
  std::string no_verdict{};                  ///< why
};

enum class CellState {
  kAsExpected,
  kMissed,
  kNoVerdict,  ///< a flight has none, and none missed
};

/// A failure in a phase: all of its seeds.
struct CellResult {
  CampaignCell cell;
  std::vector<CampaignFlight> flights{};

  CellState state() const;
  std::size_t as_expected() const;
  /// The flight that is shown: the first that missed, else that without a verdict, else the first.
  const CampaignFlight& shown() const;
  /// Over all seeds: the longest time (nothing when one of them has none), the farthest, the most.
  std::optional<double> detected_s() const;
  std::optional<double> reacted_s() const;
  double farthest_m() const;
  double peak_tilt_deg() const;
};

/// A campaign and its results.
struct CampaignMatrix {
  Campaign campaign;
  std::vector<CellResult> cells;
  std::vector<std::string> without_failure{};  ///< sentences on those that did not pass
  std::set<std::size_t> flown_otherwise{};     ///< rows that were another flight when flown again
  std::size_t references = 0;                  ///< flights without a failure that were flown
  std::string stopped{};                       ///< fault of a board that stopped the campaign
  FlightWarnings warnings{};                   ///< of all flights, with and without failures

  /// @param results  of rows 1 to the last; row 0 where one was not flown. After the cells' come
  ///                 those without a failure: a flight that is the same has seen none, and one that
  ///                 has none to compare with has no verdict. In real time no two are the same.
  static CampaignMatrix of(Campaign campaign, const std::vector<RowResult>& results);
  /// Nothing where the failure does not strike in that phase.
  const CellResult* find(std::size_t failure, std::size_t phase) const;
  std::size_t count(CellState state) const;
  /// 0: all as expected; 1: a cell missed; 3: none did, and one has no verdict or was another
  /// flight when it was flown again, or a flight without a failure did not pass.
  int exit_code() const;
};

}  // namespace cas::hils
