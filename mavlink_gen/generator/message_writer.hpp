// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "mavlink_gen/generator/naming.hpp"
#include "mavlink_gen/parser/model.hpp"

namespace cas::mav::gen {

/// Whether a field of the message has an enum for its type.
bool uses_enums(const xml::Message& message);

/// The struct of a message with its codec, view, reflection and helpers.
std::string message_struct(const xml::Message& message, const xml::Dialect& dialect,
                           const Names& names);

}  // namespace cas::mav::gen
