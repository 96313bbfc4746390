// SPDX-License-Identifier: BSD-3-Clause
#include "tests/bench/figures/consistency_figures.hpp"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <array>
#include <boost/math/distributions/chi_squared.hpp>
#include <chrono>
#include <cstddef>
#include <deque>
#include <limits>
#include <utility>

#include "base/time/clock.hpp"
#include "fcu/estimation/estimator.hpp"
#include "tests/bench/figures/direct_flight.hpp"
#include "tests/bench/figures/flight_batch.hpp"

namespace cas::hils {

namespace {

constexpr double kHeight_m = 2.5;
constexpr double kSettle_s = 10;
constexpr std::size_t kMoments = 40;
/// Between two moments: no multiple of a sensor's period, and each has a fix of its own.
constexpr double kBetween_s = 1.037;

struct Quantity {
  const char* name;
  int dimension;
};
constexpr std::array kQuantities{
    Quantity{"NEES of attitude, velocity and position", 9},
    Quantity{"NEES of attitude", 3},
    Quantity{"NEES of velocity", 3},
    Quantity{"NEES of position", 3},
    Quantity{"NIS of GPS position", 3},
    Quantity{"NIS of GPS velocity", 3},
    Quantity{"NIS of the barometer", 1},
    Quantity{"NIS of the magnetometer", 3},
};
using Squares = std::array<double, kQuantities.size()>;
using FlightSquares = std::array<Squares, kMoments>;

/// The truth at the times of the last samples: the estimate is older than the simulator.
class TruthHistory {
 public:
  void add(base::SimTime time, const DirectFlight::Truth& truth) {
    constexpr std::size_t kKept = 100;
    entries_.emplace_back(time, truth);
    if (entries_.size() > kKept) entries_.pop_front();
  }
  /// The one that is nearest in time; there is one.
  const DirectFlight::Truth& at(base::SimTime time) const {
    const auto* best = &entries_.back();
    for (const auto& entry : entries_) {
      if (std::chrono::abs(entry.first - time) < std::chrono::abs(best->first - time))
        best = &entry;
    }
    return best->second;
  }

 private:
  std::deque<std::pair<base::SimTime, DirectFlight::Truth>> entries_;
};

/// e' P^-1 e of `size` states from `first` on.
template <int Size>
double normalised_square(const Eigen::Matrix<double, 9, 1>& error,
                         const fcu::ErrorCovariance::Matrix& covariance, int first) {
  const Eigen::Matrix<double, Size, Size> p = covariance.block<Size, Size>(first, first);
  const Eigen::Matrix<double, Size, 1> e = error.segment<Size>(first);
  return e.dot(p.ldlt().solve(e));
}

Squares squares_of(const fcu::Estimator& estimator, const DirectFlight::Truth& truth) {
  using Covariance = fcu::ErrorCovariance;
  const fcu::EstimatorState& state = estimator.state();
  Eigen::Quaterniond turn = truth.q_ND * state.q_ND.inverse();
  if (turn.w() < 0) turn.coeffs() = -turn.coeffs();
  Eigen::Matrix<double, 9, 1> error;
  error << 2 * turn.vec(), truth.v_N - state.v_N, truth.p_N - state.p_N;
  const Covariance::Matrix& p = estimator.covariance().matrix();
  return {normalised_square<9>(error, p, Covariance::kTheta),
          normalised_square<3>(error, p, Covariance::kTheta),
          normalised_square<3>(error, p, Covariance::kVelocity),
          normalised_square<3>(error, p, Covariance::kPosition),
          estimator.gps_position().nis,
          estimator.gps_velocity().nis,
          estimator.baro().nis,
          estimator.mag().nis};
}

/// Takes off and goes from place to place, turning; not-a-number where it never took off.
FlightSquares fly_seed(std::uint64_t seed) {
  FlightSquares squares;
  for (Squares& each : squares) each.fill(std::numeric_limits<double>::quiet_NaN());
  DirectFlight flight({.seed = seed});
  if (!flight.take_off(kHeight_m)) return squares;
  flight.go_to(0, 0, kHeight_m, 0);
  flight.run(kSettle_s);
  TruthHistory truths;
  for (std::size_t i = 0; i < kMoments; ++i) {
    if (i % 8 == 4) {
      const bool out = i % 16 == 4;
      flight.go_to(out ? 4 : 0, 3, out ? 3.5 : kHeight_m, static_cast<double>(i % 16) / 5);
    }
    flight.run(kBetween_s, [&] { truths.add(flight.simulated_time(), flight.truth()); });
    squares[i] = squares_of(flight.estimator(), truths.at(flight.estimator().state().time));
  }
  return squares;
}

}  // namespace

ConsistencyInterval consistency_interval(int dimension, int flights) {
  constexpr double kEachEnd = 0.025;
  const boost::math::chi_squared sum(static_cast<double>(dimension) * flights);
  return {boost::math::quantile(sum, kEachEnd) / flights,
          boost::math::quantile(boost::math::complement(sum, kEachEnd)) / flights};
}

std::vector<FlightFigure> consistency_figures(const FlightBatch& batch) {
  const auto flights = fly_batch<FlightSquares>(batch, fly_seed);
  std::vector<FlightFigure> figures;
  for (std::size_t i = 0; i < kQuantities.size(); ++i) {
    const auto [name, dimension] = kQuantities[i];
    const auto [least, most] = consistency_interval(dimension, batch.flights);
    double all = 0;
    int inside = 0;
    for (std::size_t moment = 0; moment < kMoments; ++moment) {
      double mean = 0;
      for (const FlightSquares& squares : flights) mean += squares[moment][i] / batch.flights;
      all += mean / kMoments;
      if (mean >= least && mean <= most) ++inside;
    }
    figures.push_back(
        {fmt::format("{}, mean of {} flights", name, batch.flights), all, std::nullopt, "",
         fmt::format("expected {}; 95 % of means lie within {:.3f} to {:.3f}: {} of {} moments do",
                     dimension, least, most, inside, kMoments)});
  }
  return figures;
}

}  // namespace cas::hils
