// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string_view>
#include <type_traits>

/// Names of enum entries; the generated enum_text.hpp has the tables.
namespace cas::mav {

/// A parameter of a command, as the XML describes it; empty where it says nothing.
struct ParamInfo {
  std::uint8_t index{};  ///< 1..7
  std::string_view label;
  std::string_view units;
  std::string_view enum_name;
};

/// One entry of an enum.
struct EnumEntry {
  std::uint64_t value{};              ///< two's complement
  std::string_view name;              ///< as in the XML
  std::span<const ParamInfo> params;  ///< of an entry of MAV_CMD
};

/// An enum with its entries, merged over all files of the dialect.
struct EnumInfo {
  std::string_view name;  ///< as in the XML
  bool bitmask{};
  std::span<const EnumEntry> entries;
};

/// Whether the names of E are at hand: the enum_text.hpp of its dialect has them.
template <class E>
concept HasEnumText = requires(E value) {
  enum_info(value);
};

namespace detail {

template <class E>
constexpr std::uint64_t enum_bits(E value) {
  return static_cast<std::uint64_t>(static_cast<std::underlying_type_t<E>>(value));
}

}  // namespace detail

/// The entry of an enum value, nullptr for a value without a name.
template <class E>
constexpr const EnumEntry* find_entry(E value) {
  static_assert(HasEnumText<E>, "names of enums: include mavlink/<dialect>/enum_text.hpp");
  if constexpr (HasEnumText<E>) {
    for (const auto& entry : enum_info(value).entries) {
      if (entry.value == detail::enum_bits(value)) return &entry;
    }
  }
  return nullptr;
}

/// The name of an enum value as in the XML, empty for a value without one.
template <class E>
constexpr std::string_view name_of(E value) {
  static_assert(HasEnumText<E>, "names of enums: include mavlink/<dialect>/enum_text.hpp");
  if constexpr (HasEnumText<E>) {
    // Not by find_entry(): GCC's sanitizer takes no comparison with nullptr for a constant.
    for (const auto& entry : enum_info(value).entries) {
      if (entry.value == detail::enum_bits(value)) return entry.name;
    }
  }
  return {};
}

/// The value of the entry `name` of E's XML enum; nullopt when there is none.
template <class E>
constexpr std::optional<E> value_of(std::string_view name) {
  static_assert(HasEnumText<E>, "names of enums: include mavlink/<dialect>/enum_text.hpp");
  if constexpr (HasEnumText<E>) {
    for (const auto& entry : enum_info(E{}).entries) {
      if (entry.name == name) return static_cast<E>(entry.value);
    }
  }
  return std::nullopt;
}

}  // namespace cas::mav
