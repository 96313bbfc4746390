// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "mavlink_gen/parser/model.hpp"

namespace cas::mav::xml {

/// Most bytes a payload can have.
inline constexpr std::size_t kMaxPayloadBytes = 255;
/// Most fields a message can have.
inline constexpr std::size_t kMaxFields = 64;

/// Sets wire order, offsets, lengths and CRC_EXTRA from the fields.
///
/// Base fields go by the size of their element, largest first, otherwise as in the XML; extension
/// fields follow as in the XML, without padding. CRC_EXTRA covers the base fields alone.
void compute_layout(Message& message);

}  // namespace cas::mav::xml
