// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "base/error.hpp"

namespace cas::sim {

/// The run is of no further use: a vehicle is below everything in its world and falls for ever, or
/// the contact solver has given up. `what()` says which, and when.
class LeftWorldError : public base::ConfigError {
 public:
  using base::ConfigError::ConfigError;
};

}  // namespace cas::sim
