// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "mavlink_gen/parser/diagnostics.hpp"
#include "mavlink_gen/parser/element_reader.hpp"
#include "mavlink_gen/parser/model.hpp"
#include "mavlink_gen/parser/xml_document.hpp"

namespace cas::mav::xml {

struct Include {
  std::string path;
  Position position;
};

/// One dialect file before includes are merged.
struct ParsedFile {
  std::vector<Include> includes;
  std::optional<int> version, dialect;
  std::vector<Enum> enums;
  std::vector<Message> messages;
};

/// Turns the tree of one file into enums and messages and reports violations of the schema.
ParsedFile parse_file(const Element& root, Diagnostics& diagnostics);

/// Reads one `<enum>` with its entries and their parameters; nullopt where its name is missing.
/// An entry with an error is reported and left out.
std::optional<Enum> parse_enum(const Element& element, ElementReader& reader);

/// Reads one `<message>` with its fields and lays out its payload; nothing, and the reasons as
/// diagnostics, where it cannot work.
std::optional<Message> parse_message(const Element& element, ElementReader& reader);

}  // namespace cas::mav::xml
