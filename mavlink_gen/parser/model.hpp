// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "mavlink_gen/parser/diagnostics.hpp"

namespace cas::mav::xml {

/// Whole number of an enum entry: anything from -2^63 to 2^64 - 1.
struct EnumValue {
  std::uint64_t bits{};  ///< two's complement
  bool negative{};

  friend bool operator==(const EnumValue&, const EnumValue&) = default;
  bool less(const EnumValue& other) const {
    if (negative != other.negative) return negative;
    return bits < other.bits;
  }
  std::string decimal() const;
};

enum class Status : std::uint8_t { kStable, kWip, kSuperseded, kDeprecated };

/// Contents of <wip>, <superseded> and <deprecated>.
struct Lifecycle {
  Status status{Status::kStable};
  std::string since;        ///< YYYY-MM, or empty
  std::string replaced_by;  ///< name, or empty
  std::string text;
};

/// One parameter of a MAV_CMD entry.
struct Param {
  int index{};  ///< 1..7
  std::string label, units, enum_name, min_value, max_value, increment, default_value;
  bool reserved{};
  std::string text;
};

/// One value of an enum; of MAV_CMD: a command.
struct Entry {
  std::string name;
  EnumValue value;
  std::string text;
  Lifecycle lifecycle;
  std::vector<Param> params;
  bool has_location{}, is_destination{}, mission_only{};
  Position position;
};

/// One enum of a dialect: its entries, and the integer type that holds their values.
struct Enum {
  std::string name;
  bool bitmask{};
  std::string text;
  Lifecycle lifecycle;
  std::vector<Entry> entries;  ///< by value
  Position position;
  /// Narrowest integer type that holds each value, and all that each field of this type can bring.
  int bytes{1};
  bool is_signed{};
};

enum class BaseType : std::uint8_t {
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

std::size_t size_of(BaseType type);
std::string_view wire_name(BaseType type);  ///< as it counts for CRC_EXTRA, e.g. `uint8_t`
bool is_integer(BaseType type);             ///< a number without fraction; `char` is none
bool is_signed(BaseType type);
bool holds(BaseType type, const EnumValue& value);  ///< an integer type

/// One field of a message, as the XML describes it and with its place in the payload.
struct Field {
  std::string name;
  BaseType type{};
  int array_length{};  ///< 0: no array
  bool extension{};
  bool is_version{};  ///< uint8_t_mavlink_version: always `version`
  std::uint8_t version{};
  std::string enum_name, units, multiplier, invalid, print_format, default_value, min_value,
      max_value;
  bool display_bitmask{}, instance{};
  bool enum_unfit{};  ///< no type holds its enum's values and its own: it stays a number
  std::string text;
  Position position;
  std::size_t offset{};  ///< in the payload

  /// Whether its member has the type of its enum.
  bool is_enum() const { return !enum_name.empty() && is_integer(type) && !enum_unfit; }

  std::size_t bytes() const {
    return size_of(type) * static_cast<std::size_t>(array_length == 0 ? 1 : array_length);
  }
};

/// One message of a dialect, with its layout on the wire.
struct Message {
  std::uint32_t id{};
  std::string name;
  std::string text;
  Lifecycle lifecycle;
  std::vector<Field> fields;            ///< in the order of the XML
  std::vector<std::size_t> wire_order;  ///< indices into `fields`
  std::uint8_t crc_extra{};
  std::size_t min_length{}, max_length{};  ///< without and with extensions
  Position position;

  /// Offset of a scalar uint8_t field of that name, -1 where there is none.
  int byte_field_offset(std::string_view field) const;
};

/// A file and everything it includes, merged.
struct Dialect {
  std::string name;                ///< file name without .xml
  int version{};                   ///< <version>, 0 where the file has none
  int number{};                    ///< <dialect>, 0 where the file has none
  std::vector<std::string> files;  ///< every file read, this one last
  std::vector<Enum> enums;         ///< by name
  std::vector<Message> messages;   ///< by id

  const Enum* find_enum(std::string_view enum_name) const;
  const Message* find_message(std::string_view message_name) const;
};

}  // namespace cas::mav::xml
