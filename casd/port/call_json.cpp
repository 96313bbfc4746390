// SPDX-License-Identifier: BSD-3-Clause
#include "casd/port/call_json.hpp"

#include <cmath>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <utility>

#include "base/enum_words.hpp"
#include "mavlink_gen/runtime/public_table.hpp"

namespace cas::casd {

using base::rpc::Reply;
using mavlink::common::MavResult;
using mavlink::common::MavSeverity;
using mavlink::common::MavType;
using nlohmann::json;

void add_look(base::rpc::Server& server, const std::string& name,
              std::function<json(CallParams&)> look) {
  server.add_method(name, [look = std::move(look)](const json& params, const Reply& reply) {
    CallParams reader(params);
    reply.result(look(reader));
  });
}

void add_change(base::rpc::Server& server, const std::string& name, Audit audit,
                std::function<void(CallParams&, const Reply&)> change) {
  server.add_method(
      name,
      [name, audit = std::move(audit), change = std::move(change)](const json& params,
                                                                   const Reply& reply) {
        const auto refusal = run_answered(reply, [&] {
          CallParams reader(params);
          change(reader, reply);
        });
        audit(reply.client, name, params, refusal);
      },
      kWeightOfChange);
}

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

CallParams::CallParams(const json& params) : params_(params) {
  if (params_.is_null()) params_ = json::object();
  if (!params_.is_object()) throw BadParams("parameters are given by name, in an object");
}

/// The value of a key; null counts as absent.
const json* CallParams::find(const std::string& key) {
  asked_.insert(key);
  const auto found = params_.find(key);
  return found == params_.end() || found->is_null() ? nullptr : &*found;
}

std::optional<double> CallParams::optional_number(const std::string& key) {
  const json* value = find(key);
  if (value == nullptr) return std::nullopt;
  if (!value->is_number()) throw BadParams("\"" + key + "\" must be a number");
  return value->get<double>();
}

double CallParams::number(const std::string& key) {
  const std::optional<double> value = optional_number(key);
  if (!value) throw BadParams("\"" + key + "\" is missing: a number");
  return *value;
}

std::optional<std::int64_t> CallParams::optional_integer(const std::string& key, std::int64_t low,
                                                         std::int64_t high) {
  const std::optional<double> value = optional_number(key);
  if (!value) return std::nullopt;
  if (*value != std::floor(*value) || *value < static_cast<double>(low) ||
      *value > static_cast<double>(high)) {
    throw BadParams("\"" + key + "\" must be an integer from " + std::to_string(low) + " to " +
                    std::to_string(high));
  }
  return static_cast<std::int64_t>(*value);
}

std::int64_t CallParams::integer(const std::string& key, std::int64_t low, std::int64_t high) {
  const std::optional<std::int64_t> value = optional_integer(key, low, high);
  if (!value) throw BadParams("\"" + key + "\" is missing: an integer");
  return *value;
}

std::optional<std::string> CallParams::optional_text(const std::string& key) {
  const json* value = find(key);
  if (value == nullptr) return std::nullopt;
  if (!value->is_string()) throw BadParams("\"" + key + "\" must be a string");
  return value->get<std::string>();
}

std::string CallParams::text(const std::string& key) {
  const std::optional<std::string> value = optional_text(key);
  if (!value) throw BadParams("\"" + key + "\" is missing: a string");
  return *value;
}

bool CallParams::flag(const std::string& key) {
  const json* value = find(key);
  if (value == nullptr) return false;
  if (!value->is_boolean()) throw BadParams("\"" + key + "\" must be true or false");
  return value->get<bool>();
}

json CallParams::value(const std::string& key) {
  const json* found = find(key);
  return found == nullptr ? json() : *found;
}

void CallParams::finish() const {
  for (const auto& item : params_.items()) {
    if (!asked_.contains(item.key())) {
      throw BadParams("\"" + item.key() + "\" is no parameter of this method");
    }
  }
}

std::string result_word(MavResult result) {
  constexpr base::EnumWords<MavResult::kCancelled> kWords{
      "ACCEPTED", "TEMPORARILY_REJECTED", "DENIED",   "UNSUPPORTED",
      "FAILED",   "IN_PROGRESS",          "CANCELLED"};
  return result <= MavResult::kCancelled
             ? std::string(kWords[result])
             : "RESULT_" + std::to_string(static_cast<unsigned>(result));
}

std::string_view severity_word(MavSeverity severity) {
  constexpr std::string_view kWords[] = {"emergency", "alert",  "critical", "error",
                                         "warning",   "notice", "info",     "debug"};
  const auto index = static_cast<std::size_t>(severity);
  return index < std::size(kWords) ? kWords[index] : "unknown";
}

std::string type_word(MavType type) {
  switch (type) {
    case MavType::kGeneric:
      return "generic";
    case MavType::kFixedWing:
      return "fixed_wing";
    case MavType::kQuadrotor:
      return "quadrotor";
    case MavType::kHelicopter:
      return "helicopter";
    case MavType::kHexarotor:
      return "hexarotor";
    case MavType::kOctorotor:
      return "octorotor";
    case MavType::kGroundRover:
      return "rover";
    default:
      return "type " + std::to_string(static_cast<unsigned>(type));
  }
}

json parameters_json(const std::map<std::string, double>& parameters) {
  json object = json::object();
  for (const auto& [name, value] : parameters) object[name] = number_json(value);
  return object;
}

}  // namespace cas::casd
