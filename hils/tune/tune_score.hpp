// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <functional>
#include <string>
#include <vector>

#include "hils/tune/tune_study.hpp"

namespace cas::hils {

/// A figure of one flight; not a number where the flight has none.
/// @param scenario  index @param seed  index among the seeds that were flown
using FlightFigure =
    std::function<double(std::size_t scenario, std::size_t seed, const std::string& figure)>;

/// The figure over its scenarios and seeds, see TuneFigure. @param worst_is_least  of a guard that
/// has a lower bound @return not a number where a flight lacks it
double measured(const TuneFigure& figure, std::size_t seeds, const FlightFigure& of,
                bool worst_is_least = false);

/// One candidate, flown.
struct Candidate {
  std::size_t number = 0;  ///< from 0, in the order of the search; 0 is the one before
  std::vector<std::string> values{};
  std::vector<double> objectives{};  ///< not a number: a flight lacks the figure
  std::vector<double> guards{};
  std::size_t fallen = 0;  ///< flights that did not stay up (without those of a delay ramp)
  double penalty = 0;      ///< 0: all guards hold and all flights stayed up
  double sum = 0;          ///< weighted objectives as shares of those before, with penalty
};

/// Judges candidates against the one before.
class TuneScore {
 public:
  TuneScore(const TuneStudy& study, Candidate before);

  const Candidate& before() const { return before_; }
  /// Sets penalty and sum of a candidate that has its other figures.
  Candidate judged(Candidate candidate) const;
  /// Values that a search minimises: each objective relative to the candidate before tuning, and
  /// the penalty, which weighs ten times as much.
  std::vector<double> fitness(const Candidate& candidate) const;
  /// The bound of a guard.
  double bound(std::size_t guard) const;

 private:
  /// By how much a guard is missed, as a share of its bound; 0: it holds.
  double missed(std::size_t guard, double value) const;
  double share(std::size_t objective, double value) const;

  const TuneStudy& study_;
  Candidate before_;
};

/// Indices of those without penalty that no other of them is better than in one objective and as
/// good in the rest, by the first objective.
std::vector<std::size_t> pareto_front(const std::vector<Candidate>& candidates);

/// Index of the least sum among those without penalty; 0, the one before, where none of them has a
/// smaller sum than that one has with its penalty.
std::size_t best_of(const std::vector<Candidate>& candidates);

}  // namespace cas::hils
