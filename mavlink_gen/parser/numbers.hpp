// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

#include "mavlink_gen/parser/model.hpp"

namespace cas::mav::xml {

/// Reads an enum value: decimal, `0x1F`, `0b101` or `2**5`, with an optional sign, up to 64 bit.
/// The text is parsed, never evaluated.
std::optional<EnumValue> parse_enum_value(std::string_view text);

/// Reads a plain decimal number from 0 to `max`.
std::optional<std::uint32_t> parse_number(std::string_view text, std::uint32_t max);

}  // namespace cas::mav::xml
