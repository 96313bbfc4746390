// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "base/cli/verb.hpp"

namespace cas::hils {

/// Adds `hils campaign`: reads its flags, plans, flies by the sweep's engine and reports.
/// Its run() throws RunStopped, BoardError, base::ConfigError.
base::cli::Verb add_campaign(CLI::App& app);

}  // namespace cas::hils
