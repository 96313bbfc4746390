// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "hils/measure/measurement.hpp"
#include "hils/scenario/scenario.hpp"

namespace cas::hils {

/// Exit codes of hils.
enum ExitCode : int {
  kExitPassed = 0,
  kExitLimitsMissed = 1,
  kExitUsage = 2,
  kExitInvalid = 3,
  kExitInterrupted = 130,
};

/// Whether a run counts, and whether it kept its limits.
struct Verdict {
  bool valid = false;   ///< the machine kept up and the accounts close: the figures mean something
  bool passed = false;  ///< valid, flown to the end, and every limit kept
  std::vector<std::string> failures;  ///< sentences: why it is not valid, else what was missed

  ExitCode exit_code() const {
    if (!valid) return kExitInvalid;
    return passed ? kExitPassed : kExitLimitsMissed;
  }
};

/// Least simulated over elapsed time of a valid run in real time.
inline constexpr double kLeastRealTimeFactor = 0.99;
/// A run that stood still for longer than this and then missed a limit gives no verdict on the
/// vehicle: the machine may have been the cause.
inline constexpr double kStallMs = 50.0;
/// The same holds when something waited for a processor during a larger share of the measurement.
inline constexpr double kBusyShare = 0.25;

/// Judges a run: first whether it is valid, then the flight and the limits.
Verdict judge(const Measurement& figures, const Limits& limits);

}  // namespace cas::hils
