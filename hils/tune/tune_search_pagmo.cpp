// SPDX-License-Identifier: BSD-3-Clause
#include <cstddef>
#include <pagmo/algorithm.hpp>
#include <pagmo/algorithms/cmaes.hpp>
#include <pagmo/algorithms/nsga2.hpp>
#include <pagmo/batch_evaluators/member_bfe.hpp>
#include <pagmo/bfe.hpp>
#include <pagmo/population.hpp>
#include <pagmo/problem.hpp>
#include <pagmo/types.hpp>
#include <utility>
#include <vector>

#include "base/random.hpp"
#include "hils/tune/tune_search.hpp"

namespace cas::hils {

namespace {

/// The unit cube, as pagmo's problems are.
struct UnitProblem {
  const FlyPoints* fly = nullptr;
  std::size_t dimensions = 1;
  std::size_t objectives = 1;

  pagmo::vector_double fitness(const pagmo::vector_double& point) const {
    return (*fly)({point}).front();
  }
  pagmo::vector_double batch_fitness(const pagmo::vector_double& all) const {
    UnitPoints points;
    for (std::size_t at = 0; at < all.size(); at += dimensions) {
      const auto begin = all.begin() + static_cast<std::ptrdiff_t>(at);
      points.emplace_back(begin, begin + static_cast<std::ptrdiff_t>(dimensions));
    }
    pagmo::vector_double values;
    for (const std::vector<double>& each : (*fly)(points)) {
      values.insert(values.end(), each.begin(), each.end());
    }
    return values;
  }
  std::pair<pagmo::vector_double, pagmo::vector_double> get_bounds() const {
    return {pagmo::vector_double(dimensions, 0.0), pagmo::vector_double(dimensions, 1.0)};
  }
  pagmo::vector_double::size_type get_nobj() const { return objectives; }
};

}  // namespace

void cas_tune_search(const SearchPlan& plan, const FlyPoints& fly) {
  const std::vector<std::vector<double>> fitness = fly(plan.first);
  if (plan.generations == 0) return;
  const auto seed = static_cast<unsigned>(base::derive_seed(plan.seed, "tune"));
  const auto generations = static_cast<unsigned>(plan.generations);
  pagmo::population population(
      pagmo::problem(UnitProblem{
          .fly = &fly, .dimensions = plan.first[0].size(), .objectives = fitness[0].size()}),
      0, seed);
  for (std::size_t i = 0; i < plan.first.size(); ++i) {
    population.push_back(plan.first[i], fitness[i]);
  }
  if (plan.method == SearchMethod::kCmaes) {
    constexpr double kOwn = -1;  // as pagmo sets it
    constexpr double kFirstStep = 0.2;
    constexpr double kNever = 1e-12;
    pagmo::cmaes(generations, kOwn, kOwn, kOwn, kOwn, kFirstStep, kNever, kNever, false, true, seed)
        .evolve(population);
    return;
  }
  pagmo::nsga2 nsga2(generations, 0.9, 10.0, 1.0 / static_cast<double>(plan.first[0].size()), 20.0,
                     seed);
  nsga2.set_bfe(pagmo::bfe(pagmo::member_bfe()));
  nsga2.evolve(population);
}

}  // namespace cas::hils
