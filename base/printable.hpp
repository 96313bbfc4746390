// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <string_view>

#include "base/export.hpp"

namespace cas::base {

/// With `?` in the place of each character that gives a terminal orders or hides what a text says:
/// C0 but for the tab, DEL, C1 (U+0080 to U+009F), the invisible ones that turn, join or tag text
/// (U+00AD, U+061C, U+180E, U+200B to U+200F, U+2028 to U+202E, U+2060 to U+206F, U+FEFF, U+E0000
/// to U+E007F). Other bytes stay.
CAS_BASE_EXPORT std::string printable(std::string_view text);
/// The same, but lines end where they did.
CAS_BASE_EXPORT std::string printable_lines(std::string_view text);

}  // namespace cas::base
