// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "mavlink_gen/runtime/message.hpp"

namespace cas::casd {

/// Fields and values of messages: of the generated dialect, and of MAVLink XML read at run time, so
/// that a laboratory's own dialect shows names and values without a rebuild.
class MessageDecoder {
 public:
  /// Reads a dialect with what it includes. Its messages go before the generated ones.
  /// @throws base::ConfigError with the file and line of what is wrong
  void add_dialect(const std::filesystem::path& xml);

  /// [{"name", "value", "units"?}] in the order of the XML; an empty list for an unknown message.
  nlohmann::json fields(std::uint32_t message_id, std::span<const std::uint8_t> payload) const;
  /// Id of a message of a dialect that was read at run time.
  std::optional<std::uint32_t> find(std::string_view name) const;
  /// Name in a dialect that was read at run time; empty when none has it.
  std::string name(std::uint32_t message_id) const;

 private:
  struct Field {
    std::string name;
    std::string units;
    mav::FieldType type{};
    std::size_t array_length = 0;  ///< 0: no array
    std::size_t wire_offset = 0;
  };
  struct Message {
    std::string name;
    std::vector<Field> fields;
  };

  static nlohmann::json field_json(const Field& field, std::span<const std::uint8_t> payload);

  std::map<std::uint32_t, Message> messages_;
};

}  // namespace cas::casd
