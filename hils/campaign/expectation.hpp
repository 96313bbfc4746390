// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "base/config/config.hpp"
#include "hils/measure/strike_response.hpp"

namespace cas::hils {

/// One thing that must happen when a failure strikes.
struct Expectation {
  enum class Kind {
    kStaysUp,     ///< `stays_up`: flown to the end as planned, without an incident
    kNoCrash,     ///< `no_crash`: it may land early, but hits nothing, turns over nowhere
    kCrashes,     ///< `crashes`: the vehicle cannot be flown
    kNoArming,    ///< `no_arming`: the vehicle does not arm
    kTerminates,  ///< `terminates`: the vehicle stops its rotors itself
    kDetected,    ///< `detected`, `{detected_within_s: 2}`
    kFailsafe,    ///< `{failsafe: LAND/RTL, within_s: 3}`: the first mode that a failsafe chooses
    kLands,       ///< `lands`, `{lands_within_m: 10}`: of where it was struck, without a crash
    kFarthest,    ///< `{no_farther_than_m: 2}`: from the planned path
    kTilt,        ///< `{tilts_less_than_deg: 40}`
  };
  Kind kind = Kind::kStaysUp;
  std::optional<double> most{};      ///< s, m or deg
  std::vector<std::string> modes{};  ///< of kFailsafe

  bool operator==(const Expectation&) const = default;
};

/// Reads a list of expectations. @throws base::ConfigError
std::vector<Expectation> parse_expectations(const base::ConfigNode& list);

/// "lands within 10 m".
std::string to_string(const Expectation& expectation);

/// The missed expectation, as a sentence; nullopt if it was met.
std::optional<std::string> miss_of(const Expectation& expectation, const StrikeResponse& response);

}  // namespace cas::hils
