// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "mavlink_gen/parser/model.hpp"
#include "mavlink_gen/runtime/message.hpp"
#include "mavlink_gen/runtime/packet.hpp"

namespace cas::mav::services {

/// A number of JSON that reads as the float that it was: 0.1, not 0.100000001; whole ones without a
/// fraction, null for a non-finite value.
nlohmann::json number_json(double value);

/// Messages to JSON and back, by dialects known at run time: the project's, and MAVLink XML files,
/// so that a laboratory's own messages need no rebuild.
class MessageCodec {
 public:
  /// Knows the project's dialect.
  MessageCodec();
  /// Adds the messages of a dialect that was read (xml::load_dialect()); they go before those known
  /// so far.
  void add(const xml::Dialect& dialect);

  /// {"message": "ATTITUDE", "time_boot_ms": 5, "roll": 0.1, ...}: enums by name, flags joined by
  /// '|', numbers without a name as they are, NaN and infinity as null: the form of write_json().
  /// Null for an unknown message.
  nlohmann::ordered_json to_json(const PacketView& packet) const;
  /// The packet of such an object, MAVLink 2 and unsigned. Fields that it leaves out are zero, the
  /// dialect's version is filled in, null is NaN; an enum may be a number, too.
  /// @throws std::invalid_argument with an error sentence
  PacketBuffer from_json(const nlohmann::ordered_json& object, Source source,
                         std::uint8_t sequence) const;

  /// [{"name", "value", "units"?}] in the order of the XML, enums as numbers; an empty list for an
  /// unknown message.
  nlohmann::json fields(std::uint32_t message_id, std::span<const std::uint8_t> payload) const;
  /// Id of a message.
  std::optional<std::uint32_t> find(std::string_view name) const;
  /// Empty for an unknown message.
  std::string name(std::uint32_t message_id) const;

 private:
  /// Entries with their values, as two's complement.
  struct Enum {
    bool bitmask = false;
    std::vector<std::pair<std::string, std::uint64_t>> entries;
  };
  struct Field {
    std::string name;
    std::string units;
    std::string enum_name;
    FieldType type{};
    std::size_t array_length = 0;  ///< 0: no array
    std::size_t wire_offset = 0;
  };
  struct Message {
    std::string name;
    std::uint8_t crc_extra = 0;
    std::vector<std::uint8_t> empty;  ///< the payload with all fields zero, but constants
    std::vector<Field> fields;
  };
  using Payload = std::span<const std::uint8_t>;

  nlohmann::json value_json(const Field& field, Payload payload, bool enums_by_name) const;
  nlohmann::json enum_json(const Enum& names, const nlohmann::json& number) const;
  void store(const Field& field, const nlohmann::json& value, std::uint8_t* payload) const;
  nlohmann::json enum_number(const Field& field, const std::string& words) const;
  const Enum* enum_of(const Field& field) const;

  std::map<std::uint32_t, Message> messages_;
  std::map<std::string, Enum> enums_;
};

}  // namespace cas::mav::services
