// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <initializer_list>
#include <string>
#include <string_view>

#include "mavlink_gen/generator/naming.hpp"
#include "mavlink_gen/generator/output_files.hpp"
#include "mavlink_gen/parser/model.hpp"

namespace cas::mav::gen {

/// C++ headers of a dialect, in mavlink/<name>/: enums.hpp, one header a message, table.hpp,
/// all.hpp with all of these, and enum_text.hpp with the names of enum entries.
///
/// @param name  of the folder below `mavlink/` and of the namespace below `mavlink::`
Files write_cpp(const xml::Dialect& dialect, const std::string& name);

/// One header that holds the dialect of these files, and the runtime, and includes the standard
/// library alone. Several such headers may meet in one source, but none may meet the separate ones.
///
/// @param files  files of write_cpp() and runtime_files()
/// @param name  of the dialect: the folder below `mavlink/`
std::string amalgamate(const Files& files, const std::string& name);

/// A dialect as one Markdown page: messages by id with their fields, then enums and commands.
std::string write_docs(const xml::Dialect& dialect);

/// Everything known of a dialect as one JSON object; docs/develop/mavlink_gen.md describes its
/// members.
std::string write_json(const xml::Dialect& dialect);

/// Declarations of all enums and the operators of those that are bitmasks.
std::string enum_declarations(const xml::Dialect& dialect, const Names& names);

/// Names of all entries and parameters of all commands, as constexpr tables.
std::string enum_texts(const xml::Dialect& dialect, const Names& names);

/// Whether a field of the message has an enum for its type.
bool uses_enums(const xml::Message& message);

/// The struct of a message with its codec, view, reflection and helpers.
std::string message_struct(const xml::Message& message, const xml::Dialect& dialect,
                           const Names& names);

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
