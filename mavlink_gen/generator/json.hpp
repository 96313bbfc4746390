// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "mavlink_gen/parser/model.hpp"

namespace cas::mav::gen {

/// Everything known of a dialect as one JSON object; docs/develop/mavlink_gen.md describes its
/// members.
std::string write_json(const xml::Dialect& dialect);

}  // namespace cas::mav::gen
