// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <initializer_list>
#include <string>
#include <string_view>

#include "mavlink_gen/parser/model.hpp"

namespace cas::mav::gen {

/// The pieces run together.
std::string cat(std::initializer_list<std::string_view> pieces);

/// `std::uint16_t`, `float` ...
std::string cpp_type(xml::BaseType type);

/// Integer type below an enum.
std::string underlying_type(const xml::Enum& item);

/// A C++ string literal of one line.
std::string string_literal(std::string_view text);

/// Appends `text` as `///` lines of at most 100 columns.
void append_comment(std::string& out, std::string_view indent, std::string_view text);

/// The sentence for <wip>, <superseded> and <deprecated>; empty for a stable item.
std::string lifecycle_sentence(const xml::Lifecycle& lifecycle);

}  // namespace cas::mav::gen
