// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <CLI/CLI.hpp>
#include <optional>

namespace cas::base::cli {

/// Reads a program's command line. Prints help, version and errors; for a misspelt command or
/// option it suggests the nearest one.
/// @param usage_code  exit code for a bad command line
/// @return the exit code to end with; nullopt when the program goes on
std::optional<int> parse(CLI::App& app, int argc, char** argv, int usage_code);

}  // namespace cas::base::cli
