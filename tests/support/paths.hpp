// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

namespace cas::test {

/// The checkout, without a slash at the end. A function and not a macro: an object file that names
/// no folder is the same in every clone, so that ccache finds it.
const std::string& source_dir();
/// The build tree of the tests; a function for the same reason.
const std::string& binary_dir();

}  // namespace cas::test
