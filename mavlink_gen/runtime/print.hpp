// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <charconv>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <string_view>
#include <type_traits>

#include "mavlink_gen/runtime/enum_text.hpp"
#include "mavlink_gen/runtime/message.hpp"

/// Messages as JSON and as text. Enum values are printed by name, so the dialect's enum_text.hpp
/// must be included. Nothing is allocated: the text goes in pieces to a sink,
/// void(std::string_view).
namespace cas::mav {
namespace detail {

template <class T>
inline constexpr bool kPrints = !std::is_enum_v<T> || HasEnumText<T>;
template <class T, std::size_t n>
inline constexpr bool kPrints<std::array<T, n>> = kPrints<T>;

/// Whether the names of all enums in a message are at hand.
template <class Message>
constexpr bool prints() {
  constexpr Message kNone{};
  bool all = true;
  Message::for_each_field([&]<class T>(const FieldInfo&, const T&) { all = all && kPrints<T>; },
                          kNone);
  return all;
}

template <class T, class Sink>
void write_number(T value, Sink& sink) {
  std::array<char, 32> digits;
  const auto end = std::to_chars(digits.data(), digits.data() + digits.size(), value).ptr;
  sink(std::string_view(digits.data(), static_cast<std::size_t>(end - digits.data())));
}

template <class T>
constexpr bool is_finite(T value) {
  return value - value == 0;
}

/// JSON has no NaN and no infinity: they become null.
template <class T, class Sink>
void write_json_number(T value, Sink& sink) {
  if constexpr (std::is_floating_point_v<T>) {
    if (!is_finite(value)) return sink(std::string_view("null"));
  }
  write_number(value, sink);
}

/// Bytes that are not ASCII stand as if they were Latin-1: the text need not be UTF-8.
template <class Sink>
void write_json_string(std::string_view text, Sink& sink) {
  constexpr std::string_view kHex = "0123456789abcdef";
  sink(std::string_view("\""));
  for (const char c : text) {
    const auto byte = static_cast<std::uint8_t>(c);
    if (c == '"' || c == '\\') {
      const std::array<char, 2> escaped{'\\', c};
      sink(std::string_view(escaped.data(), escaped.size()));
    } else if (byte >= 0x20 && byte < 0x7F) {
      sink(std::string_view(&c, 1));
    } else {
      const std::array<char, 6> escaped{'\\', 'u', '0', '0', kHex[byte >> 4U], kHex[byte & 15U]};
      sink(std::string_view(escaped.data(), escaped.size()));
    }
  }
  sink(std::string_view("\""));
}

/// Calls piece(name) for each known flag in the value.
/// @return the bits without a name
template <class E, class Piece>
std::uint64_t for_each_flag(E value, Piece&& piece) {
  auto left = enum_bits(value);
  for (const auto& entry : enum_info(value).entries) {
    if (entry.value == 0 || (left & entry.value) != entry.value) continue;
    piece(entry.name);
    left &= ~entry.value;
  }
  return left;
}

/// A name, names of flags joined by '|', or the bare number.
template <class E, class Sink>
void write_enum(E value, Sink& sink) {
  if (const auto name = name_of(value); !name.empty()) return sink(name);
  bool first = true;
  const auto separate = [&] {
    if (!first) sink(std::string_view("|"));
    first = false;
  };
  auto left = enum_bits(value);
  if (enum_info(value).bitmask) {
    left = for_each_flag(value, [&](std::string_view name) {
      separate();
      sink(name);
    });
  }
  if (!first && left == 0) return;
  separate();
  if (first || !enum_info(value).bitmask) {
    return write_number(static_cast<std::underlying_type_t<E>>(value), sink);
  }
  write_number(left, sink);
}

template <class T, class Sink>
void write_json_value(const T& value, Sink& sink) {
  if constexpr (std::is_enum_v<T>) {
    if (!name_of(value).empty() || (enum_info(value).bitmask && enum_bits(value) != 0)) {
      sink(std::string_view("\""));
      write_enum(value, sink);
      sink(std::string_view("\""));
    } else {
      write_number(static_cast<std::underlying_type_t<T>>(value), sink);
    }
  } else if constexpr (std::is_same_v<T, char>) {
    write_json_string({&value, value == '\0' ? std::size_t{0} : std::size_t{1}}, sink);
  } else {
    write_json_number(value, sink);
  }
}

template <class T, std::size_t n, class Sink>
void write_json_value(const std::array<T, n>& values, Sink& sink) {
  if constexpr (std::is_same_v<T, char>) {
    write_json_string(text(values), sink);
  } else {
    sink(std::string_view("["));
    for (std::size_t i = 0; i < n; ++i) {
      if (i > 0) sink(std::string_view(","));
      write_json_value(values[i], sink);
    }
    sink(std::string_view("]"));
  }
}

template <class T, class Sink>
void write_text_value(const T& value, Sink& sink) {
  if constexpr (std::is_enum_v<T>) {
    write_enum(value, sink);
  } else if constexpr (std::is_same_v<T, char>) {
    write_json_value(value, sink);
  } else {
    write_number(value, sink);
  }
}

template <class T, std::size_t n, class Sink>
void write_text_value(const std::array<T, n>& values, Sink& sink) {
  if constexpr (std::is_same_v<T, char>) {
    write_json_string(text(values), sink);
  } else {
    sink(std::string_view("["));
    for (std::size_t i = 0; i < n; ++i) {
      if (i > 0) sink(std::string_view(" "));
      write_text_value(values[i], sink);
    }
    sink(std::string_view("]"));
  }
}

}  // namespace detail

/// `{"message":"ATTITUDE","time_boot_ms":5,...}`: enums by name, flags joined by '|', numbers
/// without a name as they are, NaN and infinity as null.
template <class Message, class Sink>
void write_json(const Message& message, Sink&& sink) {
  static_assert(detail::prints<Message>(),
                "enums are printed by name: include mavlink/<dialect>/enum_text.hpp");
  if constexpr (detail::prints<Message>()) {
    sink(std::string_view("{\"message\":\""));
    sink(std::string_view(Message::kName));
    sink(std::string_view("\""));
    Message::for_each_field(
        [&](const FieldInfo& field, const auto& value) {
          sink(std::string_view(",\""));
          sink(std::string_view(field.name));
          sink(std::string_view("\":"));
          detail::write_json_value(value, sink);
        },
        message);
    sink(std::string_view("}"));
  }
}

/// `ATTITUDE time_boot_ms=5 ms roll=0.1 rad ...`: enums by name, units as in the XML.
template <class Message, class Sink>
void write_text(const Message& message, Sink&& sink) {
  static_assert(detail::prints<Message>(),
                "enums are printed by name: include mavlink/<dialect>/enum_text.hpp");
  if constexpr (detail::prints<Message>()) {
    sink(std::string_view(Message::kName));
    Message::for_each_field(
        [&](const FieldInfo& field, const auto& value) {
          sink(std::string_view(" "));
          sink(std::string_view(field.name));
          sink(std::string_view("="));
          detail::write_text_value(value, sink);
          if (field.units.empty()) return;
          sink(std::string_view(" "));
          sink(std::string_view(field.units));
        },
        message);
  }
}

/// A sink over a buffer of the caller: what does not fit is cut, and complete() says so.
class BufferSink {
 public:
  explicit BufferSink(std::span<char> buffer) : buffer_(buffer) {}

  void operator()(std::string_view piece) {
    const auto room = buffer_.size() - size_;
    const auto taken = piece.size() < room ? piece.size() : room;
    std::memcpy(buffer_.data() + size_, piece.data(), taken);
    size_ += taken;
    complete_ = complete_ && taken == piece.size();
  }

  /// What fitted so far.
  std::string_view text() const { return {buffer_.data(), size_}; }
  /// Whether everything fitted.
  bool complete() const { return complete_; }

 private:
  std::span<char> buffer_;
  std::size_t size_{};
  bool complete_{true};
};

}  // namespace cas::mav
