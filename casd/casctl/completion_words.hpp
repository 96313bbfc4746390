// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "base/cli/command_tree.hpp"

namespace cas::casctl {

/// What shells offer as arguments of verbs: loops, modes and topics are known, messages and
/// parameters are asked of the casd that runs (`casctl words`).
base::cli::WordsByCommand completion_words();

}  // namespace cas::casctl
