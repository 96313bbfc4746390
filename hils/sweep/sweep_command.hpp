// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "base/cli/verb.hpp"

namespace cas::hils {

/// Adds `hils sweep` with its own verbs. Its run() throws RunStopped, base::ConfigError,
/// std::runtime_error.
base::cli::Verb add_sweep(CLI::App& app);

}  // namespace cas::hils
