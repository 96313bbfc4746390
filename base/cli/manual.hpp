// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <CLI/CLI.hpp>
#include <string>

#include "base/cli/command_tree.hpp"

namespace cas::base::cli {

/// Gives a program the hidden option `--manual man|bash|zsh|fish`: it prints the manual page or a
/// shell's completion script and ends. All four are made from the same CLI::App as `--help`.
/// @param program  the command's name, @param version  as `--version` says it
/// @param offers  words for arguments of verbs, in the completion scripts
void add_manual(CLI::App& app, const std::string& program, const std::string& version,
                const WordsByCommand& offers = {});

}  // namespace cas::base::cli
