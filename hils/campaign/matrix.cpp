// SPDX-License-Identifier: BSD-3-Clause
#include "hils/campaign/matrix.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "hils/measure/judgement.hpp"

namespace cas::hils {

namespace {

/// @param reference  the same flight without a failure; nullptr: a comparison says nothing
CampaignFlight judge_flight(const std::vector<Expectation>& expected, const RowResult& result,
                            const RowResult* reference, std::size_t row, std::uint64_t seed) {
  CampaignFlight flight{.row = row, .seed = seed, .response = result.strike};
  if (result.row == 0) {
    flight.no_verdict = "it has not been flown";
  } else if (!result.strike) {
    const bool flown = result.cause.empty() || result.outcome == RowOutcome::kPassed ||
                       result.outcome == RowOutcome::kFailed;
    flight.no_verdict =
        flown ? "never acted: " +
                    (result.cause.empty() ? "its condition never came true" : result.cause)
              : fmt::format("{}: {}", to_string(result.outcome), result.cause);
  } else if (result.strike->no_verdict) {
    flight.no_verdict = *result.strike->no_verdict;
    flight.response.reset();
  } else if (reference != nullptr && reference->run_sha256.empty()) {
    flight.no_verdict =
        "whether its failure acted is not known: the flight without a failure has no record to "
        "compare with";
    flight.response.reset();
  } else if (reference != nullptr && result.run_sha256 == reference->run_sha256) {
    flight.no_verdict = "never acted: to the byte, the flight is the one without a failure";
    flight.response.reset();
  } else {
    for (const Expectation& each : expected) {
      if (auto miss = miss_of(each, *result.strike)) flight.misses.push_back(std::move(*miss));
    }
  }
  return flight;
}

/// The longest of a time that every flight has.
template <class Time>
std::optional<double> longest(const std::vector<CampaignFlight>& flights, Time time) {
  std::optional<double> result;
  for (const CampaignFlight& flight : flights) {
    if (!flight.response) continue;
    const std::optional<double>& own = time(*flight.response);
    if (!own) return std::nullopt;
    result = std::max(result.value_or(0), *own);
  }
  return result;
}

template <class Figure>
double most(const std::vector<CampaignFlight>& flights, Figure figure) {
  double result = 0;
  for (const CampaignFlight& flight : flights) {
    if (flight.response) result = std::max(result, figure(*flight.response));
  }
  return result;
}

}  // namespace

CellState CellResult::state() const {
  const auto missed = [](const CampaignFlight& flight) { return !flight.misses.empty(); };
  if (std::ranges::any_of(flights, missed)) return CellState::kMissed;
  return as_expected() == flights.size() ? CellState::kAsExpected : CellState::kNoVerdict;
}

std::size_t CellResult::as_expected() const {
  return static_cast<std::size_t>(std::ranges::count_if(flights, [](const CampaignFlight& flight) {
    return flight.response && flight.misses.empty();
  }));
}

const CampaignFlight& CellResult::shown() const {
  auto found = std::ranges::find_if(
      flights, [](const CampaignFlight& flight) { return !flight.misses.empty(); });
  if (found == flights.end()) {
    found = std::ranges::find_if(flights,
                                 [](const CampaignFlight& flight) { return !flight.response; });
  }
  return found == flights.end() ? flights.front() : *found;
}

std::optional<double> CellResult::detected_s() const {
  return longest(flights, [](const StrikeResponse& each) -> const std::optional<double>& {
    return each.detected_s;
  });
}

std::optional<double> CellResult::reacted_s() const {
  return longest(flights, [](const StrikeResponse& each) -> const std::optional<double>& {
    return each.reacted_s;
  });
}

double CellResult::farthest_m() const {
  return most(flights, [](const StrikeResponse& each) { return each.farthest_m; });
}

double CellResult::peak_tilt_deg() const {
  return most(flights, [](const StrikeResponse& each) { return each.peak_tilt_deg; });
}

CampaignMatrix CampaignMatrix::of(Campaign campaign, const std::vector<RowResult>& results) {
  CampaignMatrix matrix{.campaign = std::move(campaign), .cells = {}};
  matrix.warnings = warnings_of(results);
  const std::vector<CampaignCell> cells = cells_of(matrix.campaign);
  const std::vector<std::uint64_t>& seeds = matrix.campaign.seeds;
  const auto result_of = [&results](std::size_t row) {
    return row <= results.size() ? results[row - 1] : RowResult{};
  };
  std::vector<RowResult> references;
  for (std::size_t i = 0; i < seeds.size(); ++i) {
    const RowResult& own = references.emplace_back(result_of(cells.size() * seeds.size() + i + 1));
    if (own.row != 0) ++matrix.references;
    if (own.row != 0 && own.outcome == RowOutcome::kPassed) continue;
    matrix.without_failure.push_back(
        fmt::format("without a failure, seed {}: {}", seeds[i],
                    own.row == 0 ? "it has not been flown"
                                 : fmt::format("{}: {}", to_string(own.outcome), own.cause)));
  }
  std::size_t row = 0;
  for (const CampaignCell& cell : cells) {
    CellResult& result = matrix.cells.emplace_back(CellResult{.cell = cell});
    const std::string& phase = matrix.campaign.phases[cell.phase].name;
    const CampaignFailure& failure = matrix.campaign.failures[cell.failure];
    const std::vector<Expectation>& expected = failure.expected.at(phase);
    for (std::size_t i = 0; i < seeds.size(); ++i) {
      const bool repeats = !failure.failure.unrecorded && matrix.campaign.is_repeatable();
      const RowResult* reference = repeats ? &references[i] : nullptr;
      ++row;
      result.flights.push_back(judge_flight(expected, result_of(row), reference, row, seeds[i]));
    }
  }
  return matrix;
}

const CellResult* CampaignMatrix::find(std::size_t failure, std::size_t phase) const {
  const auto found = std::ranges::find_if(cells, [=](const CellResult& each) {
    return each.cell.failure == failure && each.cell.phase == phase;
  });
  return found == cells.end() ? nullptr : &*found;
}

std::size_t CampaignMatrix::count(CellState state) const {
  return static_cast<std::size_t>(std::ranges::count(cells, state, &CellResult::state));
}

int CampaignMatrix::exit_code() const {
  if (count(CellState::kMissed) > 0) return kExitLimitsMissed;
  const bool is_clear = stopped.empty() && count(CellState::kNoVerdict) == 0 &&
                        without_failure.empty() && flown_otherwise.empty();
  return is_clear ? kExitPassed : kExitInvalid;
}

}  // namespace cas::hils
