// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "base/cli/command_tree.hpp"

namespace cas::casctl {

/// Shell completion for arguments of verbs: loops, modes and topics are known, messages and
/// parameters come from the running casd (`casctl words`).
base::cli::WordsByCommand completion_words();

}  // namespace cas::casctl
