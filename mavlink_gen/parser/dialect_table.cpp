// SPDX-License-Identifier: BSD-3-Clause
#include "mavlink_gen/parser/dialect_table.hpp"

#include <algorithm>

namespace cas::mav::xml {

DialectTable::DialectTable(const Dialect& dialect) {
  const auto count = std::min<std::size_t>(dialect.messages.size(), detail::kNoMessage - 1U);
  names_.reserve(count);
  for (std::size_t i = 0; i < count; ++i) {
    const auto& message = dialect.messages[i];
    names_.push_back(message.name);
    messages_.push_back(
        {message.id, message.crc_extra, static_cast<std::uint8_t>(message.min_length),
         static_cast<std::uint8_t>(message.max_length),
         static_cast<std::int16_t>(message.byte_field_offset("target_system")),
         static_cast<std::int16_t>(message.byte_field_offset("target_component")), names_.back()});
  }
  by_id_.resize(detail::slot_count(count));
  by_name_.resize(by_id_.size());
  detail::fill_slots(messages_.data(), messages_.size(), by_id_.data(), by_name_.data());
  table_ = MessageTable(messages_, by_id_, by_name_);
}

}  // namespace cas::mav::xml
