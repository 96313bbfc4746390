// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "base/cli/command_tree.hpp"
#include "base/cli/verb.hpp"

namespace cas::hils {

/// Shell completion for arguments of the verbs of `hils board`.
base::cli::WordsByCommand board_words();

/// Adds `hils board` with its own verbs. Its run() throws BoardError, RunStopped,
/// base::ConfigError, std::runtime_error.
base::cli::Verb add_board(CLI::App& app);

}  // namespace cas::hils
