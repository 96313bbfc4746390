// SPDX-License-Identifier: BSD-3-Clause
#include "hils/tune/tune_score.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>
#include <utility>

namespace cas::hils {

namespace {

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
/// Share of the value before that an objective has where a flight lacks its figure.
constexpr double kBrokenShare = 10;
/// Weight of the penalty beside the shares of the objectives, which are about 1.
constexpr double kPenaltyWeight = 10;

double norm_of(const TuneFigure& figure, std::size_t scenario, std::size_t seed,
               const FlightFigure& of) {
  if (figure.figures.size() == 1) return of(scenario, seed, figure.figures.front());
  double squares = 0;
  for (const std::string& name : figure.figures) squares += std::pow(of(scenario, seed, name), 2);
  return std::sqrt(squares);
}

bool dominates(const Candidate& a, const Candidate& b) {
  bool better = false;
  for (std::size_t i = 0; i < a.objectives.size(); ++i) {
    if (!(a.objectives[i] <= b.objectives[i])) return false;
    if (a.objectives[i] < b.objectives[i]) better = true;
  }
  return better;
}

}  // namespace

double measured(const TuneFigure& figure, std::size_t seeds, const FlightFigure& of,
                bool worst_is_least) {
  double worst = kNone;
  for (const std::size_t scenario : figure.in) {
    double sum = 0;
    for (std::size_t seed = 0; seed < seeds; ++seed) sum += norm_of(figure, scenario, seed, of);
    const double mean = sum / static_cast<double>(seeds);
    if (std::isnan(mean)) return kNone;
    const bool worse = worst_is_least ? mean < worst : mean > worst;
    if (std::isnan(worst) || worse) worst = mean;
  }
  return worst;
}

TuneScore::TuneScore(const TuneStudy& study, Candidate before)
    : study_(study), before_(std::move(before)) {
  before_ = judged(before_);
}

Candidate TuneScore::judged(Candidate candidate) const {
  candidate.penalty = static_cast<double>(candidate.fallen);
  for (std::size_t i = 0; i < study_.guards.size(); ++i) {
    candidate.penalty += missed(i, candidate.guards[i]);
  }
  for (const double objective : candidate.objectives) {
    if (std::isnan(objective)) candidate.penalty += 1;
  }
  candidate.sum = kPenaltyWeight * candidate.penalty;
  for (std::size_t i = 0; i < study_.objectives.size(); ++i) {
    candidate.sum += study_.objectives[i].weight * share(i, candidate.objectives[i]);
  }
  return candidate;
}

std::vector<double> TuneScore::fitness(const Candidate& candidate) const {
  std::vector<double> values;
  for (std::size_t i = 0; i < study_.objectives.size(); ++i) {
    values.push_back(share(i, candidate.objectives[i]) + kPenaltyWeight * candidate.penalty);
  }
  return values;
}

double TuneScore::bound(std::size_t guard) const {
  return study_.guards[guard].bound.value_or(before_.guards[guard]);
}

double TuneScore::missed(std::size_t guard, double value) const {
  const double limit = bound(guard);
  if (std::isnan(value) || std::isnan(limit)) return 1;
  const double beyond = study_.guards[guard].at_least ? limit - value : value - limit;
  if (beyond <= 0) return 0;
  return std::abs(limit) > 0 ? beyond / std::abs(limit) : beyond;
}

double TuneScore::share(std::size_t objective, double value) const {
  if (std::isnan(value)) return kBrokenShare;
  const double reference = before_.objectives[objective];
  return reference > 0 ? value / reference : value;
}

std::vector<std::size_t> pareto_front(const std::vector<Candidate>& candidates) {
  std::vector<std::size_t> front;
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    const Candidate& own = candidates[i];
    if (own.penalty > 0) continue;
    const bool beaten = std::ranges::any_of(candidates, [&own](const Candidate& other) {
      return other.penalty == 0 && dominates(other, own);
    });
    const bool known = std::ranges::any_of(
        front, [&](std::size_t j) { return candidates[j].objectives == own.objectives; });
    if (!beaten && !known) front.push_back(i);
  }
  std::ranges::stable_sort(front, {}, [&](std::size_t i) { return candidates[i].objectives; });
  return front;
}

std::size_t best_of(const std::vector<Candidate>& candidates) {
  const auto best = std::ranges::min_element(candidates, {}, [](const Candidate& candidate) {
    return std::tuple(candidate.penalty > 0, candidate.sum, candidate.number);
  });
  const bool better = best->penalty == 0 && best->sum < candidates.front().sum;
  return better ? static_cast<std::size_t>(best - candidates.begin()) : 0;
}

}  // namespace cas::hils
