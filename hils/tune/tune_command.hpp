// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "base/cli/verb.hpp"

namespace cas::hils {

/// Add `hils tune` and `hils eval`. Their run() throws RunStopped, base::ConfigError,
/// std::runtime_error.
base::cli::Verb add_tune(CLI::App& app);
base::cli::Verb add_eval(CLI::App& app);

}  // namespace cas::hils
