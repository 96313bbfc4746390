// SPDX-License-Identifier: BSD-3-Clause
#include "hils/tune/tune_score.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>
#include <vector>

namespace cas::hils {
namespace {

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

TuneStudy study() {
  TuneStudy study;
  study.objectives = {{.figure = {.name = "error", .figures = {"x"}, .in = {0}}, .weight = 2},
                      {.figure = {.name = "effort", .figures = {"u"}, .in = {0}}}};
  study.guards = {{.figure = {.name = "margin", .figures = {"m"}, .in = {0}}},
                  {.figure = {.name = "overshoot", .figures = {"o"}, .in = {0}},
                   .at_least = false,
                   .bound = 10.0}};
  return study;
}

Candidate candidate(std::size_t number, double error, double effort, double margin = 20,
                    double overshoot = 5) {
  return {.number = number, .objectives = {error, effort}, .guards = {margin, overshoot}};
}

TEST(Measured, IsTheMeanOfTheSeedsAndTheWorstOfTheScenarios) {
  const TuneFigure figure{.name = "f", .figures = {"x", "y"}, .in = {0, 2}};
  const FlightFigure of = [](std::size_t scenario, std::size_t seed, const std::string& name) {
    const double base = name == "x" ? 3 : 4;  // 5 together
    return base * (scenario == 2 ? 2 : 1) * (seed == 0 ? 1 : 3);
  };
  EXPECT_DOUBLE_EQ(measured(figure, 2, of), 20);
  EXPECT_DOUBLE_EQ(measured(figure, 2, of, true), 10);
  EXPECT_TRUE(std::isnan(
      measured(figure, 1, [&](std::size_t scenario, std::size_t seed, const std::string& name) {
        return scenario == 2 ? kNone : of(scenario, seed, name);
      })));
}

TEST(TuneScore, SharesAreOfTheValuesBeforeAndGuardsArePenalties) {
  const TuneStudy own = study();
  const TuneScore score(own, candidate(0, 0.5, 4));
  EXPECT_DOUBLE_EQ(score.before().sum, 3);
  EXPECT_DOUBLE_EQ(score.bound(0), 20);  // as before
  EXPECT_DOUBLE_EQ(score.bound(1), 10);

  const Candidate good = score.judged(candidate(1, 0.25, 4));
  EXPECT_EQ(good.penalty, 0);
  EXPECT_DOUBLE_EQ(good.sum, 2);
  EXPECT_EQ(score.fitness(good), (std::vector<double>{0.5, 1}));

  const Candidate tight = score.judged(candidate(2, 0.25, 4, 15, 12));
  EXPECT_DOUBLE_EQ(tight.penalty, 0.25 + 0.2);
  EXPECT_DOUBLE_EQ(tight.sum, 2 + 4.5);
  EXPECT_EQ(score.fitness(tight), (std::vector<double>{5, 5.5}));
}

TEST(TuneScore, AFlightThatFellOrLacksAFigureHoldsNoGuard) {
  const TuneStudy own = study();
  const TuneScore score(own, candidate(0, 0.5, 4));
  Candidate fallen = candidate(1, 0.25, 4);
  fallen.fallen = 2;
  EXPECT_EQ(score.judged(fallen).penalty, 2);
  const Candidate blind = score.judged(candidate(2, kNone, 4, kNone));
  EXPECT_EQ(blind.penalty, 2);
  EXPECT_TRUE(std::isfinite(blind.sum));
  EXPECT_GT(blind.sum, score.before().sum);
}

TEST(ParetoFront, LeavesOutWhatIsBeatenAndWhatMissesAGuard) {
  const TuneStudy own = study();
  const TuneScore score(own, candidate(0, 0.5, 4));
  std::vector<Candidate> all{score.before(),
                             score.judged(candidate(1, 0.4, 4)),  // beats the one before
                             score.judged(candidate(2, 0.6, 2)),
                             score.judged(candidate(3, 0.6, 3)),      // beaten by 2
                             score.judged(candidate(4, 0.1, 1, 10)),  // misses a guard
                             score.judged(candidate(5, 0.4, 4))};     // as 1
  EXPECT_EQ(pareto_front(all), (std::vector<std::size_t>{1, 2}));
  EXPECT_EQ(best_of(all), 1U);
  EXPECT_EQ(best_of({score.before(), score.judged(candidate(1, 0.5, 4))}), 0U);
}

/// The one before may miss a guard that has a bound of its own.
TEST(BestOf, HoldingTheGuardsAloneIsNoGain) {
  const TuneStudy own = study();
  const TuneScore score(own, candidate(0, 0.5, 4, 20, 10.1));  // a penalty of 0.01
  EXPECT_EQ(best_of({score.before(), score.judged(candidate(1, 0.6, 4))}), 0U);
  EXPECT_EQ(best_of({score.before(), score.judged(candidate(1, 0.4, 4))}), 1U);
  EXPECT_EQ(best_of({score.before(), score.judged(candidate(1, 0.1, 4, 20, 10.05))}), 0U);
}

}  // namespace
}  // namespace cas::hils
