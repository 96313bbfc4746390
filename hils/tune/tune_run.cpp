// SPDX-License-Identifier: BSD-3-Clause
#include "hils/tune/tune_run.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include "base/error.hpp"
#include "hils/sweep/sampling.hpp"
#include "hils/tune/tune_search.hpp"

namespace cas::hils {

namespace {

using Values = std::vector<std::string>;

bool stayed_up(const RowResult& result) {
  return result.figures.size() > kUpFigure && result.figures[kUpFigure] == 1;
}

/// Flies candidates and measures the study's figures.
class Evaluator {
 public:
  Evaluator(const TuneStudy& study, TuneFlights& flights) : study_(study), flights_(flights) {}

  std::vector<Candidate> measure(const std::vector<Values>& candidates) {
    const std::size_t scenarios = study_.scenarios.size();
    const std::size_t seeds = study_.seeds.size();
    std::vector<TuneFlight> wanted;
    for (const Values& values : candidates) {
      const std::vector<TuneFlight> own = flights_of(values);
      wanted.insert(wanted.end(), own.begin(), own.end());
    }
    const std::vector<RowResult> results = flights_.fly(wanted);
    std::vector<Candidate> measured_ones;
    for (std::size_t c = 0; c < candidates.size(); ++c) {
      const auto result = [&](std::size_t scenario, std::size_t seed) -> const RowResult& {
        return results[(c * scenarios + scenario) * seeds + seed];
      };
      measured_ones.push_back(measure_one(candidates[c], result));
    }
    return measured_ones;
  }

  /// The flights before must have everything that others are compared with. They have been flown.
  void check_before(const Candidate& before) {
    const std::vector<TuneFlight> wanted = flights_of(before.values);
    const std::vector<RowResult> results = flights_.fly(wanted);
    for (std::size_t i = 0; i < results.size(); ++i) {
      // A delay may make a flight invalid, and its end is known all the same.
      const bool ramp = study_.scenarios[wanted[i].scenario].delay_ramp.has_value();
      if (ramp ? results[i].figures.empty() : !is_judged(results[i].outcome)) {
        throw base::ConfigError("with the values before, " + told(wanted[i], results[i]));
      }
    }
    if (before.fallen > 0) {
      throw base::ConfigError(
          fmt::format("{} flights with the values before did not stay up: the search has nothing "
                      "to compare with; choose other 'from' values or an easier scenario",
                      before.fallen));
    }
    const auto check = [&](const TuneFigure& figure) {
      for (std::size_t i = 0; i < results.size(); ++i) {
        if (std::ranges::find(figure.in, wanted[i].scenario) == figure.in.end()) continue;
        for (const std::string& name : figure.figures) {
          if (!std::isnan(flights_.figure(wanted[i].scenario, results[i], name))) continue;
          throw base::ConfigError("'" + figure.name +
                                  "': a flight with the values before has no '" + name +
                                  "': " + told(wanted[i], results[i]));
        }
      }
    };
    for (const Objective& each : study_.objectives) check(each.figure);
    for (const Guard& each : study_.guards) {
      if (!each.bound || each.figure.figures.front() == kDelayMargin) check(each.figure);
    }
  }

 private:
  std::vector<TuneFlight> flights_of(const Values& values) const {
    std::vector<TuneFlight> flights;
    for (std::size_t i = 0; i < study_.scenarios.size(); ++i) {
      for (const std::uint64_t seed : study_.seeds) flights.push_back({i, seed, values});
    }
    return flights;
  }

  std::string told(const TuneFlight& flight, const RowResult& result) const {
    return fmt::format("scenario '{}', seed {}, {}{}{}", study_.scenarios[flight.scenario].name,
                       flight.seed, to_string(result.outcome), result.cause.empty() ? "" : ": ",
                       result.cause);
  }

  template <class ResultOf>
  Candidate measure_one(const Values& values, const ResultOf& result) const {
    Candidate candidate{.values = values};
    const FlightFigure figure = [&](std::size_t scenario, std::size_t seed,
                                    const std::string& name) {
      return flights_.figure(scenario, result(scenario, seed), name);
    };
    const std::size_t seeds = study_.seeds.size();
    for (const Objective& each : study_.objectives) {
      candidate.objectives.push_back(measured(each.figure, seeds, figure));
    }
    for (const Guard& each : study_.guards) {
      candidate.guards.push_back(measured(each.figure, seeds, figure, each.at_least));
    }
    for (std::size_t i = 0; i < study_.scenarios.size(); ++i) {
      for (std::size_t seed = 0; seed < seeds; ++seed) {
        if (!study_.scenarios[i].delay_ramp && !stayed_up(result(i, seed))) ++candidate.fallen;
      }
    }
    return candidate;
  }

  const TuneStudy& study_;
  TuneFlights& flights_;
};

void check_figures(const TuneStudy& study, const TuneFlights& flights) {
  const auto check = [&](const TuneFigure& figure) {
    for (const std::size_t scenario : figure.in) {
      for (const std::string& name : figure.figures) {
        if (flights.has_figure(scenario, name)) continue;
        throw base::ConfigError(fmt::format(
            "'{}': scenario '{}' has no figure '{}'; docs/use/sweep.md lists the columns{}",
            figure.name, study.scenarios[scenario].name, name,
            name == kDelayMargin ? ", and this one takes a 'delay_ramp'" : ""));
      }
    }
  };
  for (const Objective& each : study.objectives) check(each.figure);
  for (const Guard& each : study.guards) check(each.figure);
}

UnitPoints first_generation(const TuneStudy& study) {
  std::vector<std::string> names;
  std::vector<double> from;
  for (const TuneParameter& each : study.vary) {
    names.push_back(each.parameter.name);
    from.push_back(each.place());
  }
  UnitPoints points =
      unit_points(Sampling::kLatinHypercube, study.population - 1, names, study.seed);
  points.insert(points.begin(), from);
  return points;
}

class Verifier {
 public:
  Verifier(const TuneStudy& study, TuneFlights& flights) : study_(study), flights_(flights) {}

  void verify(const Values& before, const Values& after, TuneResult& result) {
    const std::vector<TuneScenario>& scenarios = flights_.scenarios();
    const std::size_t seeds = study_.verify_seeds.size();
    std::vector<TuneFlight> wanted;
    for (const Values& values : {before, after}) {
      for (std::size_t i = 0; i < scenarios.size(); ++i) {
        for (const std::uint64_t seed : study_.verify_seeds) wanted.push_back({i, seed, values});
      }
    }
    const std::vector<RowResult> flown = flights_.fly(wanted);
    const std::size_t half = wanted.size() / 2;
    for (std::size_t i = 0; i < scenarios.size(); ++i) {
      const std::vector<RowResult> old(flown.begin() + offset(i * seeds),
                                       flown.begin() + offset((i + 1) * seeds));
      const std::vector<RowResult> now(flown.begin() + offset(half + i * seeds),
                                       flown.begin() + offset(half + (i + 1) * seeds));
      if (!scenarios[i].delay_ramp) {
        result.verify_flights += seeds;
        result.fallen_before += fallen(old);
        result.fallen_after += fallen(now);
      }
      compare(i, old, now, result.verification);
    }
  }

 private:
  static std::ptrdiff_t offset(std::size_t index) { return static_cast<std::ptrdiff_t>(index); }
  static std::size_t fallen(const std::vector<RowResult>& results) {
    return static_cast<std::size_t>(
        std::ranges::count_if(results, [](const RowResult& each) { return !stayed_up(each); }));
  }

  void compare(std::size_t scenario, const std::vector<RowResult>& old,
               const std::vector<RowResult>& now, std::vector<Verification>& rows) const {
    std::set<std::vector<std::string>> compared;  // a figure may be an objective and a guard
    const auto is_new = [&](const TuneFigure& figure) {
      const bool in_search = scenario < study_.scenarios.size();
      const bool asked = !in_search || std::ranges::find(figure.in, scenario) != figure.in.end();
      return asked && compared.insert(figure.figures).second;
    };
    for (const Objective& each : study_.objectives) {
      if (!flights_.scenarios()[scenario].delay_ramp && is_new(each.figure)) {
        add(scenario, each.figure, false, old, now, rows);
      }
    }
    for (const Guard& each : study_.guards) {
      const bool ramp = flights_.scenarios()[scenario].delay_ramp.has_value();
      const bool margin = each.figure.figures.front() == kDelayMargin;
      if (ramp == margin && is_new(each.figure))
        add(scenario, each.figure, each.at_least, old, now, rows);
    }
  }

  void add(std::size_t scenario, const TuneFigure& figure, bool more_is_better,
           const std::vector<RowResult>& old, const std::vector<RowResult>& now,
           std::vector<Verification>& rows) const {
    for (const std::string& name : figure.figures) {
      if (!flights_.has_figure(scenario, name)) return;
    }
    TuneFigure here = figure;
    here.in = {scenario};
    Verification row{.scenario = flights_.scenarios()[scenario].name,
                     .figure = figure.name,
                     .in_search = scenario < study_.scenarios.size(),
                     .more_is_better = more_is_better,
                     .seeds = old.size()};
    const auto of = [&](const std::vector<RowResult>& results) {
      return FlightFigure([&](std::size_t, std::size_t seed, const std::string& name) {
        return flights_.figure(scenario, results[seed], name);
      });
    };
    row.before = measured(here, old.size(), of(old));
    row.after = measured(here, now.size(), of(now));
    for (std::size_t i = 0; i < old.size(); ++i) {
      const auto one = [&](const std::vector<RowResult>& results) {
        return measured(here, 1, of({results[i]}));
      };
      const double was = one(old);
      const double is = one(now);
      if (more_is_better ? is > was : is < was) ++row.better;
    }
    rows.push_back(std::move(row));
  }

  const TuneStudy& study_;
  TuneFlights& flights_;
};

/// What the search flies: judges each point, and notes each candidate once.
class CandidateFlights {
 public:
  CandidateFlights(const TuneStudy& study, Evaluator& evaluator, const TuneScore& score,
                   std::vector<Candidate>& candidates)
      : study_(study), evaluator_(evaluator), score_(score), candidates_(candidates) {
    candidates_.push_back(score.before());
    known_.insert(study.before());
  }

  /// @return the fitness of each point
  std::vector<std::vector<double>> fly(const UnitPoints& points) {
    std::vector<Values> all;
    for (const std::vector<double>& point : points) all.push_back(values_at(point));
    std::vector<std::vector<double>> fitness;
    for (Candidate& measured_one : evaluator_.measure(all)) {
      Candidate candidate = score_.judged(std::move(measured_one));
      fitness.push_back(score_.fitness(candidate));
      if (study_.method == SearchMethod::kCmaes) fitness.back() = {candidate.sum};
      candidate.number = candidates_.size();
      if (known_.insert(candidate.values).second) candidates_.push_back(std::move(candidate));
    }
    return fitness;
  }

 private:
  Values values_at(const std::vector<double>& point) const {
    Values values;
    for (std::size_t i = 0; i < point.size(); ++i) {
      values.push_back(study_.vary[i].value_at(point[i]));
    }
    return values;
  }

  const TuneStudy& study_;
  Evaluator& evaluator_;
  const TuneScore& score_;
  std::vector<Candidate>& candidates_;
  std::set<Values> known_;
};

}  // namespace

TuneResult tune(const TuneStudy& study, TuneFlights& flights) {
  check_figures(study, flights);
  const std::size_t flights_each = study.scenarios.size() * study.seeds.size();
  flights.expect((study.population * (study.generations + 1) + 1) * flights_each +
                 2 * flights.scenarios().size() * study.verify_seeds.size());
  Evaluator evaluator(study, flights);
  const TuneScore score(study, evaluator.measure({study.before()}).front());
  evaluator.check_before(score.before());

  TuneResult result;
  for (std::size_t i = 0; i < study.guards.size(); ++i) result.bounds.push_back(score.bound(i));
  CandidateFlights candidates(study, evaluator, score, result.candidates);
  search({.method = study.method,
          .generations = study.generations,
          .seed = study.seed,
          .first = first_generation(study)},
         [&candidates](const UnitPoints& points) { return candidates.fly(points); });
  result.front = pareto_front(result.candidates);
  result.best = best_of(result.candidates);
  if (!study.verify_seeds.empty()) {
    Verifier(study, flights).verify(study.before(), result.candidates[result.best].values, result);
  }
  result.warnings = flights.warnings();
  return result;
}

}  // namespace cas::hils
