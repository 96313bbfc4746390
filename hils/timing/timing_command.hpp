// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "base/cli/verb.hpp"

namespace cas::hils {

/// Adds `hils timing`, which measures the line to a controller before any flight.
/// Its run() throws BoardError, base::ConfigError.
base::cli::Verb add_timing(CLI::App& app);

}  // namespace cas::hils
