// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <string>

#include "base/config/config.hpp"
#include "base/config/vehicle.hpp"

namespace cas::base {

/// An output's index, from its number 1..16. @throws ConfigError for another one
inline int output_of(const ConfigNode& node) {
  const int number = node.as<int>();
  if (number < 1 || number > kMaxOutputs) {
    node.fail("must lie in [1, " + std::to_string(kMaxOutputs) + "]");
  }
  return number - 1;
}

/// The outputs of an autopilot that rotors and servos of a vehicle have taken.
class OutputUse {
 public:
  /// @param output  index
  /// @throws ConfigError at `at` when something else has it
  void take(const ConfigNode& at, int output) {
    if (++users_[static_cast<std::size_t>(output)] > 1) {
      at.fail("output " + std::to_string(output + 1) + " drives something else already");
    }
  }

 private:
  std::array<int, kMaxOutputs> users_{};
};

}  // namespace cas::base
