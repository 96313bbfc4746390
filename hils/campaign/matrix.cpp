// SPDX-License-Identifier: BSD-3-Clause
#include "hils/campaign/matrix.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "hils/measure/judgement.hpp"

namespace cas::hils {

namespace {

CampaignFlight judge_flight(const std::vector<Expectation>& expected, const RowResult& result,
                            std::size_t row, std::uint64_t seed) {
  CampaignFlight flight{.row = row, .seed = seed, .response = result.strike};
  if (result.row == 0) {
    flight.no_verdict = "it has not been flown";
  } else if (!result.strike) {
    const bool flown = result.cause.empty() || result.outcome == RowOutcome::kPassed ||
                       result.outcome == RowOutcome::kFailed;
    flight.no_verdict =
        flown ? "the failure never struck: " +
                    (result.cause.empty() ? "its condition never came true" : result.cause)
              : fmt::format("{}: {}", to_string(result.outcome), result.cause);
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
  std::size_t row = 0;
  for (const CampaignCell& cell : cells_of(matrix.campaign)) {
    CellResult& result = matrix.cells.emplace_back(CellResult{.cell = cell});
    const std::string& phase = matrix.campaign.phases[cell.phase].name;
    const std::vector<Expectation>& expected =
        matrix.campaign.failures[cell.failure].expected.at(phase);
    for (const std::uint64_t seed : matrix.campaign.seeds) {
      const RowResult flown = row < results.size() ? results[row] : RowResult{};
      result.flights.push_back(judge_flight(expected, flown, ++row, seed));
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
  return count(CellState::kNoVerdict) > 0 ? kExitInvalid : kExitPassed;
}

}  // namespace cas::hils
