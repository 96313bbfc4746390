// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>

#include "mavlink_gen/parser/element_reader.hpp"
#include "mavlink_gen/parser/model.hpp"

namespace cas::mav::xml {

/// Reads one `<message>` with its fields and lays out its payload; nothing, and the reasons as
/// diagnostics, where it cannot work.
std::optional<Message> parse_message(const Element& element, ElementReader& reader);

}  // namespace cas::mav::xml
