// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>

namespace cas::hils {

/// One thing that a run is held to: a bound on a figure, or something that must not happen.
struct LimitCheck {
  enum class Kind {
    kValidity,  ///< whether the run counts
    kFlight,    ///< how good it is
  };
  enum class Sense { kAtMost, kAtLeast };
  enum class About {
    kOther,
    kMachine,  ///< whether it kept up with real time
    kRms,      ///< RMS error of the true position or the estimate
  };

  Kind kind = Kind::kFlight;
  std::string what{};             ///< "RMS error of the true position, x_m"
  std::string unit{};             ///< of value and bound
  int digits = 4;                 ///< after the point, of value and margin
  Sense sense = Sense::kAtMost;   ///< of the bound
  std::optional<double> value{};  ///< nothing where there is none, or no number
  std::optional<double> bound{};
  std::string found{};     ///< in words where value is no number: "none"
  std::string wanted{};    ///< in words where bound is no number: "none"
  bool judged = true;      ///< false: it decides nothing, because the run does not count
  bool kept = true;        ///< means nothing where it is not judged
  std::string sentence{};  ///< why it was missed; empty when it was kept
  About about = About::kOther;
  std::optional<double> time_s{};  ///< simulated, at which it was missed; of an event

  /// How far the value is from the bound, in its unit; negative beyond it.
  std::optional<double> margin() const {
    if (!value || !bound) return std::nullopt;
    return sense == Sense::kAtMost ? *bound - *value : *value - *bound;
  }
};

}  // namespace cas::hils
