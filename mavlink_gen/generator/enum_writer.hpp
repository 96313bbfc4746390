// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "mavlink_gen/generator/naming.hpp"
#include "mavlink_gen/parser/model.hpp"

namespace cas::mav::gen {

/// Declarations of all enums and the operators of those that are bitmasks.
std::string enum_declarations(const xml::Dialect& dialect, const Names& names);

/// Names of all entries and parameters of all commands, as constexpr tables.
std::string enum_texts(const xml::Dialect& dialect, const Names& names);

}  // namespace cas::mav::gen
