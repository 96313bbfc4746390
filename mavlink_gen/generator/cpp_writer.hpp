// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "mavlink_gen/generator/output_files.hpp"
#include "mavlink_gen/parser/model.hpp"

namespace cas::mav::gen {

/// C++ headers of a dialect, in mavlink/<name>/: enums.hpp, one header a message, table.hpp,
/// all.hpp with all of these, and enum_text.hpp with the names of enum entries.
///
/// @param name  of the folder below `mavlink/` and of the namespace below `mavlink::`
Files write_cpp(const xml::Dialect& dialect, const std::string& name);

}  // namespace cas::mav::gen
