// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "base/cli/verb.hpp"

namespace cas::hils {

/// Adds `hils compare`: flies and reports a comparison. Its run() returns 0, or 3 when no run of
/// some variant is valid, and throws RunStopped, base::ConfigError.
base::cli::Verb add_compare(CLI::App& app);

}  // namespace cas::hils
