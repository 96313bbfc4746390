// SPDX-License-Identifier: BSD-3-Clause
#include "mavlink_gen/parser/layout.hpp"

#include <algorithm>
#include <numeric>
#include <string>

#include "mavlink_gen/runtime/crc.hpp"

namespace cas::mav::xml {
namespace {

std::vector<std::size_t> wire_order(const Message& message) {
  std::vector<std::size_t> order(message.fields.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    const auto& left = message.fields[a];
    const auto& right = message.fields[b];
    if (left.extension != right.extension) return right.extension;
    return !left.extension && size_of(left.type) > size_of(right.type);
  });
  return order;
}

std::uint8_t crc_extra(const Message& message) {
  std::string text = message.name + ' ';
  for (const auto index : message.wire_order) {
    const auto& field = message.fields[index];
    if (field.extension) break;
    text += std::string(wire_name(field.type)) + ' ' + field.name + ' ';
    if (field.array_length > 0) text += static_cast<char>(field.array_length);
  }
  const auto crc =
      Crc16().update({reinterpret_cast<const std::uint8_t*>(text.data()), text.size()});
  return static_cast<std::uint8_t>((crc.value() & 0xFFU) ^ (crc.value() >> 8U));
}

}  // namespace

void compute_layout(Message& message) {
  message.wire_order = wire_order(message);
  std::size_t offset = 0;
  message.min_length = 0;
  for (const auto index : message.wire_order) {
    auto& field = message.fields[index];
    field.offset = offset;
    offset += field.bytes();
    if (!field.extension) message.min_length = offset;
  }
  message.max_length = offset;
  message.crc_extra = crc_extra(message);
}

}  // namespace cas::mav::xml
