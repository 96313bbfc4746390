// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

namespace cas::hils {

/// How candidates are made.
enum class SearchMethod {
  kNsga2,  ///< many objectives, a front
  kCmaes,  ///< the weighted sum alone
};

/// Points of the unit cube.
using UnitPoints = std::vector<std::vector<double>>;

/// Method, size and start of a search.
struct SearchPlan {
  SearchMethod method = SearchMethod::kNsga2;
  std::size_t generations = 10;
  std::uint64_t seed = 1;
  UnitPoints first{};  ///< the first generation; its size is the population's
};

/// Flies points. @return the fitness of each: numbers that shall become small, one of them for
/// CMA-ES
using FlyPoints = std::function<std::vector<std::vector<double>>(const UnitPoints&)>;

/// Whether this build has a library that searches.
bool has_search();

/// Makes points and flies them: with NSGA-II a generation at once, with CMA-ES one after the other.
/// The same plan and fitness give the same points. Passes exceptions of `fly` on.
/// @throws base::ConfigError where this build has no library for it, with how to get one
void search(const SearchPlan& plan, const FlyPoints& fly);

/// Entry point of the search library: search() with pagmo. pagmo fills 20 MiB of a process when it
/// starts, and most processes of hils search nothing.
extern "C" __attribute__((visibility("default"))) void cas_tune_search(const SearchPlan& plan,
                                                                       const FlyPoints& fly);
/// Symbol of cas_tune_search() in that library.
inline constexpr const char* kTuneSearch = "cas_tune_search";

}  // namespace cas::hils
