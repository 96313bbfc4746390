// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "base/cli/command_tree.hpp"
#include "casd/casctl/session/command_line.hpp"

namespace cas::casctl {

/// The verb `monitor`: the full screen, or with --once its figures as a table.
/// @param words  casctl's own completion, which the prompt shares
void add_monitor_verb(CommandLine& line, base::cli::WordsByCommand words);

}  // namespace cas::casctl
