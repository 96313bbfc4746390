// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "mavlink_gen/parser/model.hpp"

namespace cas::mav::gen {

/// Leaves only the messages named, and the enums that their fields and those enums' parameters use.
/// Everything kept is as in the whole dialect, down to the width of the enums.
/// @return a sentence about the first name that the dialect has no message of; nullopt: it has all
std::optional<std::string> keep_only(xml::Dialect& dialect,
                                     const std::vector<std::string>& messages);

}  // namespace cas::mav::gen
