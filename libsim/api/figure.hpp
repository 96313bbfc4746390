// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string_view>

#include "base/time/clock.hpp"

namespace cas::sim {

/// Presentation of a figure that a plugin publishes.
enum class FigureKind : std::uint8_t {
  kSeries,  ///< a curve over time, with its least, mean, greatest and last value
  kScalar   ///< the last value alone
};

/// A value of a figure. Non-finite values are counted and left out.
struct FigureSample {
  static constexpr std::string_view kTypeName = "cas.FigureSample";
  static constexpr unsigned kTypeVersion = 1;
  base::SimTime time;
  double value = 0;
};

}  // namespace cas::sim
