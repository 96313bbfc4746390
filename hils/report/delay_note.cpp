// SPDX-License-Identifier: BSD-3-Clause
#include "hils/report/delay_note.hpp"

#include <algorithm>

#include "hils/measure/figure_table.hpp"

namespace cas::hils {

namespace {

/// Whether a delay is too negative to be printed as zero microseconds.
bool is_negative(const DelayFigures& delay) {
  constexpr double kRoundsToZero_us = -0.5;
  return std::min({delay.p50, delay.p90, delay.p99, delay.max}) < kRoundsToZero_us;
}

}  // namespace

bool has_negative_delay(const Measurement& figures) {
  return std::ranges::any_of(
      kDelays, [&](const Delay& delay) { return is_negative(figures.*delay.figures); });
}

bool has_negative_hop(const Measurement& figures) {
  return std::ranges::any_of(figures.paths, [](const PathAccount& path) {
    return std::ranges::any_of(path.hops, is_negative, &HopFigures::delay);
  });
}

}  // namespace cas::hils
