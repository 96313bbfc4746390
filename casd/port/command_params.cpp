// SPDX-License-Identifier: BSD-3-Clause
#include "casd/port/command_params.hpp"

#include <cmath>

#include "mavlink_gen/runtime/public_table.hpp"

namespace cas::casd {

using nlohmann::json;

std::uint32_t message_id(const json& message) {
  if (message.is_number_unsigned() && message.get<std::uint64_t>() <= 0xffffff) {
    return message.get<std::uint32_t>();
  }
  if (!message.is_string()) throw BadParams("\"message\" must be a MAVLink message's name or id");
  const mav::MessageInfo* info = mav::public_table().find(message.get<std::string>());
  if (info == nullptr) {
    throw BadParams("no public dialect has a message '" + message.get<std::string>() + "'");
  }
  return info->id;
}

CommandParams::CommandParams(const json& params) : params_(params) {
  if (params_.is_null()) params_ = json::object();
  if (!params_.is_object()) throw BadParams("parameters are given by name, in an object");
}

/// The value of a key; null counts as absent.
const json* CommandParams::find(const std::string& key) {
  asked_.insert(key);
  const auto found = params_.find(key);
  return found == params_.end() || found->is_null() ? nullptr : &*found;
}

std::optional<double> CommandParams::optional_number(const std::string& key) {
  const json* value = find(key);
  if (value == nullptr) return std::nullopt;
  if (!value->is_number()) throw BadParams("\"" + key + "\" must be a number");
  return value->get<double>();
}

double CommandParams::number(const std::string& key) {
  const std::optional<double> value = optional_number(key);
  if (!value) throw BadParams("\"" + key + "\" is missing: a number");
  return *value;
}

std::optional<std::int64_t> CommandParams::optional_integer(const std::string& key,
                                                            std::int64_t low, std::int64_t high) {
  const std::optional<double> value = optional_number(key);
  if (!value) return std::nullopt;
  if (*value != std::floor(*value) || *value < static_cast<double>(low) ||
      *value > static_cast<double>(high)) {
    throw BadParams("\"" + key + "\" must be an integer from " + std::to_string(low) + " to " +
                    std::to_string(high));
  }
  return static_cast<std::int64_t>(*value);
}

std::int64_t CommandParams::integer(const std::string& key, std::int64_t low, std::int64_t high) {
  const std::optional<std::int64_t> value = optional_integer(key, low, high);
  if (!value) throw BadParams("\"" + key + "\" is missing: an integer");
  return *value;
}

std::optional<std::string> CommandParams::optional_text(const std::string& key) {
  const json* value = find(key);
  if (value == nullptr) return std::nullopt;
  if (!value->is_string()) throw BadParams("\"" + key + "\" must be a string");
  return value->get<std::string>();
}

std::string CommandParams::text(const std::string& key) {
  const std::optional<std::string> value = optional_text(key);
  if (!value) throw BadParams("\"" + key + "\" is missing: a string");
  return *value;
}

bool CommandParams::flag(const std::string& key) {
  const json* value = find(key);
  if (value == nullptr) return false;
  if (!value->is_boolean()) throw BadParams("\"" + key + "\" must be true or false");
  return value->get<bool>();
}

json CommandParams::value(const std::string& key) {
  const json* found = find(key);
  return found == nullptr ? json() : *found;
}

void CommandParams::finish() const {
  for (const auto& item : params_.items()) {
    if (!asked_.contains(item.key())) {
      throw BadParams("\"" + item.key() + "\" is no parameter of this method");
    }
  }
}

}  // namespace cas::casd
