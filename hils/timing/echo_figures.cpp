// SPDX-License-Identifier: BSD-3-Clause
#include "hils/timing/echo_figures.hpp"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <numbers>
#include <vector>

namespace cas::hils {

namespace {

using namespace std::chrono_literals;

/// Too few neighbours look like frames by chance: with 50 the mean's deviation is 0.1.
constexpr std::size_t kLeastNeighbours = 50;
constexpr double kLeastAgreement = 0.7;
/// Beyond it a frame clock that is 500 ppm off has moved too far.
constexpr base::Duration kLongestBetween = 60ms;
constexpr std::array<base::Duration, 3> kFrames{16ms, 1ms, 125us};

double to_ms(base::Duration time) { return 1e3 * base::to_seconds(time); }

double agreement(std::span<const base::Duration> between, base::Duration frame) {
  double sum = 0;
  for (const base::Duration time : between) {
    sum += std::cos(2 * std::numbers::pi * base::to_seconds(time) / base::to_seconds(frame));
  }
  return sum / static_cast<double>(between.size());
}

}  // namespace

EchoFigures echo_figures(std::size_t asked, std::span<const base::Duration> round_trips) {
  EchoFigures figures{.asked = asked, .answered = round_trips.size()};
  if (round_trips.empty()) return figures;
  std::vector<base::Duration> sorted(round_trips.begin(), round_trips.end());
  std::ranges::sort(sorted);
  const auto at = [&sorted](double share) {
    return to_ms(sorted[static_cast<std::size_t>(share * static_cast<double>(sorted.size() - 1))]);
  };
  figures.least_ms = at(0);
  figures.median_ms = at(0.5);
  figures.p99_ms = at(0.99);
  figures.longest_ms = at(1);
  double sum = 0;
  for (std::size_t i = 1; i < round_trips.size(); ++i) {
    sum += std::abs(to_ms(round_trips[i] - round_trips[i - 1]));
  }
  if (round_trips.size() > 1) figures.jitter_ms = sum / static_cast<double>(round_trips.size() - 1);
  return figures;
}

std::optional<base::Duration> arrival_frame(std::span<const base::RunTime> arrivals) {
  std::vector<base::Duration> between;
  for (std::size_t i = 1; i < arrivals.size(); ++i) {
    const base::Duration time = arrivals[i] - arrivals[i - 1];
    if (time <= kLongestBetween) between.push_back(time);
  }
  if (between.size() < kLeastNeighbours) return std::nullopt;
  for (const base::Duration frame : kFrames) {
    if (agreement(between, frame) > kLeastAgreement) return frame;
  }
  return std::nullopt;
}

}  // namespace cas::hils
