// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

namespace cas::fcu {

/// Every key of FcuConfig with its default and meaning, and those of its line, as tables in
/// Markdown: what `fcu_emulator --keys` prints and docs/config.md shows.
std::string controller_reference();

}  // namespace cas::fcu
