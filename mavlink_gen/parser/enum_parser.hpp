// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>

#include "mavlink_gen/parser/element_reader.hpp"
#include "mavlink_gen/parser/model.hpp"

namespace cas::mav::xml {

/// Reads one `<enum>` with its entries and their parameters; nullopt where its name is missing.
/// An entry with an error is reported and left out.
std::optional<Enum> parse_enum(const Element& element, ElementReader& reader);

}  // namespace cas::mav::xml
