// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <optional>
#include <span>

#include "base/time/clock.hpp"

namespace cas::hils {

/// Round-trip figures of a number of questions. Times in ms; 0 if none was answered.
struct EchoFigures {
  std::size_t asked = 0;
  std::size_t answered = 0;
  double least_ms = 0;
  double median_ms = 0;
  double p99_ms = 0;
  double longest_ms = 0;
  double jitter_ms = 0;  ///< mean difference between a round trip and the one before

  std::size_t lost() const { return asked - answered; }
  double lost_share() const {
    return asked == 0 ? 0 : static_cast<double>(lost()) / static_cast<double>(asked);
  }
};

/// @param round_trips  of those that were answered, in their order
EchoFigures echo_figures(std::size_t asked, std::span<const base::Duration> round_trips);

/// The frames in which answers arrive: those of USB (1 ms, at high speed 125 us) or of an adapter's
/// latency timer (16 ms). In frames, the time between two arrivals is a whole number of them,
/// whatever the time between the questions; for each length P this computes the mean of
/// cos(2 pi t / P) over the times t between neighbours, 1 for exact frames and 0 without, and tells
/// the longest P above 0.7. Frames whose clock is 500 ppm off are still found.
/// @param arrivals  of answers to questions at random times, no more than some 20 ms apart
/// @return nullopt: no frames, or this program's wake-ups blur them
std::optional<base::Duration> arrival_frame(std::span<const base::RunTime> arrivals);

}  // namespace cas::hils
