// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <type_traits>

#include "mavlink_gen/runtime/text_view.hpp"

/// What a generated message header needs: metadata of fields, and little-endian loads and stores.
namespace cas::mav {

/// Type of a field, or of an array's elements, on the wire.
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
  TextView name;       ///< as in the XML
  TextView units;      ///< as in the XML, e.g. `degE7`
  TextView enum_name;  ///< as in the XML
  TextView invalid;    ///< the value that stands for unknown, as in the XML
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
    std::uint8_t bytes[sizeof(T)], swapped[sizeof(T)];
    std::memcpy(bytes, &value, sizeof value);
    for (std::size_t i = 0; i < sizeof(T); ++i) swapped[i] = bytes[sizeof(T) - 1 - i];
    std::memcpy(&value, swapped, sizeof value);
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

/// Loads an array element by element; elements that need no conversion go at once.
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
constexpr TextView text(const std::array<char, n>& characters) {
  std::size_t size = 0;
  while (size < n && characters[size] != '\0') ++size;
  return {characters.data(), size};
}

/// Copies `value`, cut to n characters, and fills the rest with NULs.
template <std::size_t n>
constexpr void set_text(std::array<char, n>& characters, TextView value) {
  for (std::size_t i = 0; i < n; ++i) characters[i] = i < value.size() ? value[i] : '\0';
}

/// Borrowed payload that may be truncated: missing bytes read as zero. Base of the generated
/// views.
class PayloadView {
 public:
  constexpr PayloadView(const std::uint8_t* data, std::size_t size) : data_(data), size_(size) {}

 protected:
  /// A number, enum or array that takes `bytes` bytes on the wire.
  template <class Wire, class T, std::size_t bytes>
  T at_(std::size_t offset) const {
    T value;
    if (offset + bytes <= size_) {
      get<Wire>(data_ + offset, value);
      return value;
    }
    std::array<std::uint8_t, bytes> filled{};
    if (offset < size_) std::memcpy(filled.data(), data_ + offset, size_ - offset);
    get<Wire>(filled.data(), value);
    return value;
  }

  /// Characters up to the first NUL, the field's or the payload's end.
  TextView text_at_(std::size_t offset, std::size_t length) const {
    if (offset >= size_) return {};
    const auto present = size_ - offset < length ? size_ - offset : length;
    const auto* characters = reinterpret_cast<const char*>(data_ + offset);
    std::size_t size = 0;
    while (size < present && characters[size] != '\0') ++size;
    return {characters, size};
  }

 private:
  const std::uint8_t* data_;
  std::size_t size_;
};

// --- quantities ----------------------------------------------------------------------------------

/// Whether the value is NaN; false for integers.
template <class T>
constexpr bool is_nan(T value) {
  return !(value == value);
}

/// Whether every element is NaN.
template <class T, std::size_t n>
constexpr bool all_nan(const std::array<T, n>& values) {
  for (const auto value : values) {
    if (!is_nan(value)) return false;
  }
  return true;
}

/// Whether every element is `wanted`.
template <class T, std::size_t n>
constexpr bool all_equal(const std::array<T, n>& values, T wanted) {
  for (const auto& value : values) {
    if (value != wanted) return false;
  }
  return true;
}

namespace detail {

/// Least and greatest value of an integer type; <limits> would cost every sender more than its
/// message.
template <class T>
inline constexpr T kMax = static_cast<T>(std::is_signed_v<T>
                                             ? (std::uint64_t{1} << (8 * sizeof(T) - 1)) - 1
                                             : ~std::uint64_t{0});
template <class T>
inline constexpr T kMin = static_cast<T>(-kMax<T> - 1);

inline constexpr auto kNan = std::bit_cast<double>(std::uint64_t{0x7FF8000000000000});

}  // namespace detail

/// A raw field as a quantity in a plain unit: raw * factor / divisor.
template <class T>
constexpr double to_quantity(T raw, double factor, double divisor) {
  return static_cast<double>(raw) * factor / divisor;
}

/// Likewise, NaN for the raw value that stands for unknown.
template <class T, class U>
constexpr double to_quantity(T raw, double factor, double divisor, U unknown) {
  if (raw == static_cast<T>(unknown)) return detail::kNan;
  return to_quantity(raw, factor, divisor);
}

/// The nearest raw value of a quantity, held within the type's range. NaN gives 0 for integers.
template <class T>
constexpr T from_quantity(double quantity, double factor, double divisor) {
  const auto raw = quantity * divisor / factor;
  if constexpr (std::is_integral_v<T>) {
    if (is_nan(raw)) return 0;
    if (raw <= static_cast<double>(detail::kMin<T>)) return detail::kMin<T>;
    if (raw >= static_cast<double>(detail::kMax<T>)) return detail::kMax<T>;
    return static_cast<T>(raw + (raw < 0 ? -0.5 : 0.5));
  } else {
    return static_cast<T>(raw);
  }
}

/// Likewise; NaN gives the raw value that stands for unknown, and no quantity beyond the range
/// does.
template <class T, class U>
constexpr T from_quantity(double quantity, double factor, double divisor, U unknown) {
  if (is_nan(quantity)) return static_cast<T>(unknown);
  const auto raw = from_quantity<T>(quantity, factor, divisor);
  if constexpr (std::is_integral_v<T>) {
    const bool at_top = raw == detail::kMax<T> && raw == static_cast<T>(unknown);
    return at_top ? static_cast<T>(raw - 1) : raw;
  } else {
    return raw;
  }
}

}  // namespace cas::mav
