// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "base/cli/verb.hpp"

namespace cas::hils {

/// Adds `hils run`, which flies one scenario. Its run() throws BoardError, RunStopped,
/// base::ConfigError.
base::cli::Verb add_run(CLI::App& app);

}  // namespace cas::hils
