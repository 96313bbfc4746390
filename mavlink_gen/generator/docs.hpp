// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "mavlink_gen/parser/model.hpp"

namespace cas::mav::gen {

/// A dialect as one Markdown page: messages by id with their fields, then enums and commands.
std::string write_docs(const xml::Dialect& dialect);

}  // namespace cas::mav::gen
