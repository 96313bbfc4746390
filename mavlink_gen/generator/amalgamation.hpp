// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "mavlink_gen/generator/output_files.hpp"

namespace cas::mav::gen {

/// One header that holds the dialect of these files, and the runtime, and includes the standard
/// library alone. Several such headers may meet in one source, but none may meet the separate ones.
///
/// @param files  files of write_cpp() and runtime_files()
/// @param name  of the dialect: the folder below `mavlink/`
std::string amalgamate(const Files& files, const std::string& name);

}  // namespace cas::mav::gen
