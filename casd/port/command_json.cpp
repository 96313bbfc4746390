// SPDX-License-Identifier: BSD-3-Clause
#include "casd/port/command_json.hpp"

#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <nlohmann/json.hpp>

#include "casd/station/param_exchange.hpp"

namespace cas::casd {

using mavlink::common::MavResult;
using mavlink::common::MavSeverity;
using mavlink::common::MavType;
using nlohmann::json;

std::string result_word(MavResult result) {
  switch (result) {
    case MavResult::kAccepted:
      return "ACCEPTED";
    case MavResult::kTemporarilyRejected:
      return "TEMPORARILY_REJECTED";
    case MavResult::kDenied:
      return "DENIED";
    case MavResult::kUnsupported:
      return "UNSUPPORTED";
    case MavResult::kFailed:
      return "FAILED";
    case MavResult::kInProgress:
      return "IN_PROGRESS";
    case MavResult::kCancelled:
      return "CANCELLED";
    default:
      return "RESULT_" + std::to_string(static_cast<unsigned>(result));
  }
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

json number_json(double value) {
  constexpr double kExact = 9007199254740992;  // 2^53
  if (!std::isfinite(value)) return nullptr;
  if (value == std::floor(value) && std::abs(value) < kExact) {
    return static_cast<std::int64_t>(value);
  }
  return std::strtod(number_text(value).c_str(), nullptr);
}

json parameters_json(const std::map<std::string, double>& parameters) {
  json object = json::object();
  for (const auto& [name, value] : parameters) object[name] = number_json(value);
  return object;
}

}  // namespace cas::casd
