// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <CLI/CLI.hpp>
#include <cstdio>
#include <string>

namespace cas::base::cli {

/// Gives a program or a verb a flag that prints a reference, and ends.
/// @param reference  makes the tables
/// @param help  "Print every figure"
inline void add_reference_flag(CLI::App& app, const std::string& flag, std::string (*reference)(),
                               const std::string& help) {
  app.add_flag_callback(
      flag,
      [reference] {
        std::fputs(reference().c_str(), stdout);
        throw CLI::Success();
      },
      help + ", and end");
}

/// Gives a program or a verb the flag `--keys`: it prints every key of its configuration file, and
/// ends.
/// @param file  kind of the file: "a topology"
/// @param flag  name of the flag, for a second kind of file
inline void add_keys_flag(CLI::App& app, std::string (*reference)(), const std::string& file,
                          const std::string& flag = "--keys") {
  add_reference_flag(app, flag, reference,
                     "Print every key of " + file + " with its default and meaning");
}

}  // namespace cas::base::cli
