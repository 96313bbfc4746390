// SPDX-License-Identifier: BSD-3-Clause
#include "hils/measure/record_hole.hpp"

#include <fmt/format.h>

#include <cstdint>

#include "base/time/clock.hpp"

namespace cas::hils {
namespace {

/// 50 samples of the recorder. A vehicle that falls for this long exceeds kCrashSpeed_m_s.
constexpr std::int64_t kHole_us = 500'000;

double seconds(std::int64_t time_us) { return 1e-6 * static_cast<double>(time_us); }

}  // namespace

std::optional<std::string> record_hole(const std::vector<Stage>& stages,
                                       std::span<const PoseSample> truth) {
  if (stages.empty()) return std::nullopt;
  if (truth.empty()) return "it is empty";
  const std::int64_t begin_us = to_microseconds(stages.front().begin);
  const std::int64_t end_us = to_microseconds(stages.back().end);
  if (truth.front().time_us - begin_us >= kHole_us) {
    return fmt::format("it begins at {:.2f} s, and the flight at {:.2f} s",
                       seconds(truth.front().time_us), seconds(begin_us));
  }
  std::int64_t before_us = truth.front().time_us;
  for (const PoseSample& sample : truth) {
    if (sample.time_us < before_us) {
      return fmt::format("its time goes back, from {:.2f} s to {:.2f} s", seconds(before_us),
                         seconds(sample.time_us));
    }
    const bool in_flight = sample.time_us > begin_us && before_us < end_us;
    if (in_flight && sample.time_us - before_us >= kHole_us) {
      return fmt::format("it has nothing between {:.2f} s and {:.2f} s", seconds(before_us),
                         seconds(sample.time_us));
    }
    before_us = sample.time_us;
  }
  if (end_us - before_us < kHole_us) return std::nullopt;
  return fmt::format("it ends at {:.2f} s, and the flight at {:.2f} s", seconds(before_us),
                     seconds(end_us));
}

}  // namespace cas::hils
