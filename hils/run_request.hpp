// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <filesystem>

#include "hils/scenario.hpp"

namespace cas::hils {

/// One run of a scenario.
struct RunRequest {
  Scenario scenario;
  Architecture architecture = Architecture::kTcas;
  std::uint64_t seed = 1;
  std::filesystem::path out;  ///< folder of the results; what the programs were given is in out/run
};

}  // namespace cas::hils
