// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "tests/bench/figures/flight_figures.hpp"

namespace cas::hils {

/// Where the mean of `flights` independent normalised squares of `dimension` lies with a
/// probability of 95 %, both ends alike. [Bar-Shalom] Sect. 5.4.2. Pure.
struct ConsistencyInterval {
  double least = 0;
  double most = 0;
};
ConsistencyInterval consistency_interval(int dimension, int flights);

/// Whether the estimator's errors are as large as its covariance says: over flights with manoeuvres
/// (table1), the means of normalised squares of its errors against the truth (NEES) and of its
/// innovations (NIS). Each has its dimension as expected value; at each of 40 moments the mean over
/// all flights is held against consistency_interval(). Shown, not judged.
std::vector<FlightFigure> consistency_figures(const FlightBatch& batch);

}  // namespace cas::hils
