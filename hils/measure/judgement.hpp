// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "hils/measure/limit_check.hpp"
#include "hils/measure/measurement.hpp"
#include "hils/scenario/scenario.hpp"

namespace cas::hils {

/// Exit codes of hils.
enum ExitCode : int {
  kExitPassed = 0,
  kExitLimitsMissed = 1,
  kExitUsage = 2,
  kExitInvalid = 3,
  kExitBoardAbsent = 4,  ///< a board's device is not there
  kExitNoBoot = 5,       ///< a board does not boot, or boots another firmware
  kExitBoardFailed = 6,  ///< a board's hook failed, or the board refused
  kExitBoardBusy = 7,    ///< another holds the board
  kExitInterrupted = 130,
};

/// Whether a run counts, and whether it kept its limits.
struct Verdict {
  bool valid = false;   ///< the machine kept up and the accounts close: the figures mean something
  bool passed = false;  ///< valid, flown to the end, and every limit kept
  std::vector<std::string> failures;   ///< sentences: why it is not valid, else the missed limits
  std::vector<LimitCheck> checks{};    ///< all that it was held to, kept or not; of one vehicle
  std::vector<std::string> remarks{};  ///< what a reader of a green line must know; decide nothing
  /// What was flown otherwise than the files of world and vehicle say; decide nothing.
  std::vector<std::string> warnings{};

  ExitCode exit_code() const {
    if (!valid) return kExitInvalid;
    return passed ? kExitPassed : kExitLimitsMissed;
  }
  /// PASSED, FAILED or INVALID.
  std::string_view word() const {
    if (!valid) return "INVALID";
    return passed ? "PASSED" : "FAILED";
  }
};

/// Least simulated over elapsed time of a valid run in real time.
inline constexpr double kLeastRealTimeFactor = 0.99;
/// Longest pause in the stream of a valid run: ten periods of a 200 Hz stream; a
/// controller takes its sensors for dead after 300 (PX4).
inline constexpr double kMostStallMs = 50.0;
/// Limit for the lateness of 99 % of a valid run's HIL_SENSOR, and for 99 % of the delays of one
/// hop between two programs: one period of the stream. A later sample arrives after its successor
/// was due. At 500 Hz these 2 ms cost a rate loop that crosses over at 40 rad/s 5 degrees of phase.
double most_late_ms(const Measurement& figures);

/// Holds a value to its bound.
/// @param bounded  name, unit, digits, sense and bound
/// @param reached  whether the flight came so far that it could be measured; else a value that is
///                 missing is not judged
void check_bound(LimitCheck bounded, std::optional<double> value, bool reached,
                 std::vector<LimitCheck>& checks);

/// Adds one vehicle's verdict to that on several, which begins as valid and passed.
void merge_verdict(const std::string& vehicle, const Verdict& own, Verdict& together);

/// Judges a run: first whether it is valid, then the flight and the limits.
Verdict judge(const Measurement& figures, const Limits& limits);

}  // namespace cas::hils
