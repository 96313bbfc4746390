// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

namespace cas::casctl {

/// With `?` in the place of each control character and each invisible one: texts come from the
/// wire, and must neither move the cursor nor give a terminal orders.
std::string printable(std::string text);
/// The same, but lines end where they did.
std::string printable_lines(const std::string& text);

}  // namespace cas::casctl
