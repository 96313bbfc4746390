// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

namespace cas::hils {

/// Table of the shipped scenarios for a terminal, by name: the word that `hils run` takes, the
/// controller that flies it and what it is. A file that is none has its fault in the last column.
std::string list_scenarios();

}  // namespace cas::hils
