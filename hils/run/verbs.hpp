// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "base/cli/verb.hpp"

namespace cas::hils {

// Verbs of the program hils, each defined in NAME_command.cpp. Their run() throws base::ConfigError
// and the errors named here.

/// Adds `hils compare`: flies and reports a comparison. Its run() returns 0, or 3 when no run of
/// some variant is valid, and throws RunStopped.
base::cli::Verb add_compare(CLI::App& app);
/// Adds `hils campaign`: reads its flags, plans, flies by the sweep's engine and reports. Its run()
/// throws RunStopped, BoardError.
base::cli::Verb add_campaign(CLI::App& app);
/// Adds `hils sweep` with its own verbs. Its run() throws RunStopped, std::runtime_error.
base::cli::Verb add_sweep(CLI::App& app);
/// Add `hils tune` and `hils eval`. Their run() throws RunStopped, std::runtime_error.
base::cli::Verb add_tune(CLI::App& app);
base::cli::Verb add_eval(CLI::App& app);
/// Adds `hils timing`, which measures the line to a controller before any flight. Its run() throws
/// BoardError.
base::cli::Verb add_timing(CLI::App& app);
/// Adds `hils replay`, which makes the page of recorded runs and flight logs.
base::cli::Verb add_replay(CLI::App& app);
/// Adds `hils explain`, which tells the story of a finished run.
base::cli::Verb add_explain(CLI::App& app);
/// Adds `hils runs`, which lists the runs below a folder and writes the page that compares two.
base::cli::Verb add_runs(CLI::App& app);

}  // namespace cas::hils
