// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <CLI/CLI.hpp>
#include <optional>

namespace cas::base::cli {

/// Reads a program's command line. Help, version and what is wrong with it are printed here; of a
/// misspelt command or option, the one that may have been meant.
/// @param usage_code  exit code of a command line that is wrong
/// @return the exit code to end with; nothing when the program goes on
std::optional<int> parse(CLI::App& app, int argc, char** argv, int usage_code);

}  // namespace cas::base::cli
