// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "hils/tune/tune_flights.hpp"
#include "hils/tune/tune_score.hpp"

namespace cas::hils {

/// One figure of one scenario over seeds that the search never used, before and after.
struct Verification {
  std::string scenario;
  std::string figure;
  bool in_search = false;  ///< the search flew this scenario, with other seeds
  bool more_is_better = false;
  std::size_t seeds = 0;
  std::size_t better = 0;  ///< seeds in which the candidate is better
  double before = 0;       ///< mean over the seeds
  double after = 0;
};

/// Result of a tuning.
struct TuneResult {
  std::vector<Candidate> candidates;  ///< [0]: before; then in the order in which they were made
  std::vector<std::size_t> front;     ///< indices
  std::size_t best = 0;               ///< 0: none is better than the one before
  std::vector<double> bounds;         ///< of the guards
  std::vector<Verification> verification;
  std::size_t verify_flights = 0;  ///< with each candidate, without those of delay ramps
  std::size_t fallen_before = 0;   ///< of those, that did not stay up
  std::size_t fallen_after = 0;
  FlightWarnings warnings;  ///< of all flights
};

/// Flies the candidate before, searches, and verifies the best one. The same study gives the same.
/// @throws base::ConfigError where the flights before lack a figure, RunStopped
TuneResult tune(const TuneStudy& study, TuneFlights& flights);

}  // namespace cas::hils
