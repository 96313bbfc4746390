// SPDX-License-Identifier: BSD-3-Clause
#include "casd/port/call_json.hpp"

#include <fmt/format.h>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <string_view>
#include <utility>
#include <vector>

#include "base/enum_words.hpp"
#include "base/suggestion.hpp"
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
  const auto word = message.get<std::string>();
  const mav::MessageInfo* info = mav::public_table().find(word);
  if (info == nullptr) {
    std::vector<std::string_view> known;
    for (const mav::MessageInfo& each : mav::public_table().all()) known.emplace_back(each.name);
    throw BadParams("no public dialect has a message '" + word + "'" +
                    base::did_you_mean(word, known));
  }
  return info->id;
}

std::string result_word(MavResult result) {
  constexpr base::EnumWords<MavResult::kCancelled> kWords{
      "ACCEPTED", "TEMPORARILY_REJECTED", "DENIED",   "UNSUPPORTED",
      "FAILED",   "IN_PROGRESS",          "CANCELLED"};
  return result <= MavResult::kCancelled ? std::string(kWords[result])
                                         : fmt::format("RESULT_{}", static_cast<unsigned>(result));
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
      return fmt::format("type {}", static_cast<unsigned>(type));
  }
}

json parameters_json(const std::map<std::string, double>& parameters) {
  json object = json::object();
  for (const auto& [name, value] : parameters) object[name] = number_json(value);
  return object;
}

}  // namespace cas::casd
