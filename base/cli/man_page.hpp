// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "base/cli/command_tree.hpp"

namespace cas::base::cli {

/// The manual page of a program, in man(7) macros.
/// @param date  of the text: "2026-11-22"
std::string man_page(const std::string& program, const std::string& version,
                     const std::string& date, const Command& command);

}  // namespace cas::base::cli
