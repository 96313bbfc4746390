// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <optional>
#include <string>

#include "base/time/clock.hpp"

namespace cas::hils {

/// How far a sweep is.
struct SweepState {
  std::size_t all = 0;       ///< runs of the part that is flown
  std::size_t done = 0;      ///< of them, also before this process
  std::size_t flown = 0;     ///< by this process
  std::size_t unjudged = 0;  ///< of those, without a verdict
  base::Duration elapsed{};  ///< since this process began
  const char* verb = "sweep";
};

/// "sweep: [######----] 600 of 1000, 4.2 runs/s, 1:35 left, 2 without a verdict". The time left
/// appears once ten runs, or a twentieth, have been flown.
std::string sweep_line(const SweepState& state);

/// Shows the progress of a sweep or a tuning on standard error: one line that is rewritten on a
/// terminal; elsewhere a new line for each tenth.
class SweepProgress {
 public:
  SweepProgress();
  ~SweepProgress();
  SweepProgress(const SweepProgress&) = delete;
  SweepProgress& operator=(const SweepProgress&) = delete;

  void show(const SweepState& state);
  void clear();

 private:
  bool terminal_;
  bool drawn_ = false;
  std::optional<std::size_t> tenth_;
};

}  // namespace cas::hils
