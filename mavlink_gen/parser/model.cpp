// SPDX-License-Identifier: BSD-3-Clause
#include "mavlink_gen/parser/model.hpp"

#include <algorithm>
#include <array>

namespace cas::mav::xml {
namespace {

struct TypeFacts {
  std::string_view name;
  std::size_t size;
  bool integer, negative;
};

constexpr std::array<TypeFacts, 11> kTypes{{{"char", 1, false, false},
                                            {"uint8_t", 1, true, false},
                                            {"int8_t", 1, true, true},
                                            {"uint16_t", 2, true, false},
                                            {"int16_t", 2, true, true},
                                            {"uint32_t", 4, true, false},
                                            {"int32_t", 4, true, true},
                                            {"uint64_t", 8, true, false},
                                            {"int64_t", 8, true, true},
                                            {"float", 4, false, true},
                                            {"double", 8, false, true}}};

const TypeFacts& facts(BaseType type) { return kTypes[static_cast<std::size_t>(type)]; }

}  // namespace

std::size_t size_of(BaseType type) { return facts(type).size; }
std::string_view wire_name(BaseType type) { return facts(type).name; }
bool is_integer(BaseType type) { return facts(type).integer; }
bool is_signed(BaseType type) { return facts(type).negative; }

bool holds(BaseType type, const EnumValue& value) {
  const auto bits = static_cast<unsigned>(size_of(type)) * 8U;
  if (!is_signed(type)) return !value.negative && (bits == 64 || value.bits >> bits == 0);
  const auto top = std::uint64_t{1} << (bits - 1U);
  return value.negative ? ~value.bits < top : value.bits < top;
}

std::string EnumValue::decimal() const {
  return negative ? '-' + std::to_string(~bits + 1) : std::to_string(bits);
}

int Message::byte_field_offset(std::string_view field) const {
  const auto it = std::find_if(fields.begin(), fields.end(), [&](const Field& f) {
    return f.name == field && f.type == BaseType::kUint8 && f.array_length == 0;
  });
  return it == fields.end() ? -1 : static_cast<int>(it->offset);
}

const Enum* Dialect::find_enum(std::string_view enum_name) const {
  const auto it = std::lower_bound(enums.begin(), enums.end(), enum_name,
                                   [](const Enum& e, std::string_view n) { return e.name < n; });
  return it != enums.end() && it->name == enum_name ? &*it : nullptr;
}

const Message* Dialect::find_message(std::string_view message_name) const {
  const auto it = std::find_if(messages.begin(), messages.end(),
                               [&](const Message& m) { return m.name == message_name; });
  return it == messages.end() ? nullptr : &*it;
}

}  // namespace cas::mav::xml
