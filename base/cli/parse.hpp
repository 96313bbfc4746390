// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <CLI/CLI.hpp>
#include <optional>

namespace cas::base::cli {

/// Reads a program's command line. Help, version and what is wrong with it are printed here.
/// @param usage_code  exit code of a command line that is wrong
/// @return the exit code to end with; nothing when the program goes on
inline std::optional<int> parse(CLI::App& app, int argc, char** argv, int usage_code) {
  try {
    app.parse(argc, argv);
    return std::nullopt;
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : usage_code;
  }
}

}  // namespace cas::base::cli
