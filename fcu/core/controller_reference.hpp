// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

namespace cas::fcu {

/// Every key of FcuConfig with its default and meaning, and those of its line, as tables in
/// Markdown: for `fcu_emulator --keys` and docs/reference/config.md.
std::string controller_reference();

}  // namespace cas::fcu
