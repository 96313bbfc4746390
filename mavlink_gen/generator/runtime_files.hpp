// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "mavlink_gen/generator/output_files.hpp"

namespace cas::mav::gen {

/// The headers below generated code, by the names it includes them by. The build puts their text
/// into the program, so one that was copied somewhere alone still has them.
const Files& runtime_files();

}  // namespace cas::mav::gen
