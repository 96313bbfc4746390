// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string_view>
#include <type_traits>

/// What a generated message header needs: metadata of fields, and little-endian loads and stores.
namespace cas::mav {

enum class FieldType : std::uint8_t {
  kChar,
  kUint8,
  kInt8,
  kUint16,
  kInt16,
  kUint32,
  kInt32,
  kUint64,
  kInt64,
  kFloat,
  kDouble
};

/// Facts of one field of a message.
struct FieldInfo {
  std::string_view name;       ///< as in the XML
  std::string_view units;      ///< as in the XML, e.g. `degE7`
  std::string_view enum_name;  ///< as in the XML
  std::string_view invalid;    ///< the value that stands for unknown, as in the XML
  FieldType type{};
  std::uint8_t array_length{};  ///< 0: no array
  std::uint8_t wire_offset{};   ///< in the payload
  bool extension{};
  bool instance{};  ///< tells apart several senders of one message, e.g. a sensor's number
};

namespace detail {

template <class T>
inline T to_little_endian(T value) {
  if constexpr (std::endian::native == std::endian::big && sizeof(T) > 1) {
    auto bytes = std::bit_cast<std::array<std::uint8_t, sizeof(T)>>(value);
    for (std::size_t i = 0; i < sizeof(T) / 2; ++i) std::swap(bytes[i], bytes[sizeof(T) - 1 - i]);
    return std::bit_cast<T>(bytes);
  }
  return value;
}

}  // namespace detail

/// Stores a number or enum as the little-endian type `Wire`.
template <class Wire, class T>
inline void put(std::uint8_t* out, const T& value) {
  const auto wire = detail::to_little_endian(static_cast<Wire>(value));
  std::memcpy(out, &wire, sizeof wire);
}

/// Stores an array element by element; elements that need no conversion go at once.
template <class Wire, class T, std::size_t n>
inline void put(std::uint8_t* out, const std::array<T, n>& values) {
  if constexpr (sizeof(T) == sizeof(Wire) &&
                (std::endian::native == std::endian::little || sizeof(Wire) == 1)) {
    std::memcpy(out, values.data(), sizeof values);
  } else {
    for (const auto& value : values) {
      put<Wire>(out, value);
      out += sizeof(Wire);
    }
  }
}

/// Loads a number or enum from the little-endian type `Wire`.
template <class Wire, class T>
inline void get(const std::uint8_t* in, T& value) {
  Wire wire;
  std::memcpy(&wire, in, sizeof wire);
  value = static_cast<T>(detail::to_little_endian(wire));
}

template <class Wire, class T, std::size_t n>
inline void get(const std::uint8_t* in, std::array<T, n>& values) {
  if constexpr (sizeof(T) == sizeof(Wire) &&
                (std::endian::native == std::endian::little || sizeof(Wire) == 1)) {
    std::memcpy(values.data(), in, sizeof values);
  } else {
    for (auto& value : values) {
      get<Wire>(in, value);
      in += sizeof(Wire);
    }
  }
}

/// The characters up to the first NUL, or all.
template <std::size_t n>
constexpr std::string_view text(const std::array<char, n>& characters) {
  std::size_t size = 0;
  while (size < n && characters[size] != '\0') ++size;
  return {characters.data(), size};
}

/// Copies `value`, cut to n characters, and fills the rest with NULs.
template <std::size_t n>
constexpr void set_text(std::array<char, n>& characters, std::string_view value) {
  for (std::size_t i = 0; i < n; ++i) characters[i] = i < value.size() ? value[i] : '\0';
}

}  // namespace cas::mav
