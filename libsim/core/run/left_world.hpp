// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "base/error.hpp"

namespace cas::sim {

/// A vehicle is below everything in its world and falls for ever: the run is of no further use.
/// `what()` names vehicle, time and place.
class LeftWorldError : public base::ConfigError {
 public:
  using base::ConfigError::ConfigError;
};

}  // namespace cas::sim
