// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "base/cli/command_tree.hpp"

namespace cas::base::cli {

/// Completion scripts: they offer verbs, options and a verb's words by the cursor's position, else
/// files.
std::string bash_completion(const std::string& program, const Command& command);
std::string zsh_completion(const std::string& program, const Command& command);
std::string fish_completion(const std::string& program, const Command& command);

}  // namespace cas::base::cli
