// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>

#include "mavlink/common/enums.hpp"

/// Words and values of the command port.
namespace cas::casd {

/// "ACCEPTED", "DENIED", ...: the MAV_RESULT names without their prefix.
std::string result_word(mavlink::common::MavResult result);
/// "emergency" ... "debug", by syslog's names.
std::string_view severity_word(mavlink::common::MavSeverity severity);
/// "quadrotor", "hexarotor", ..., "type 27".
std::string type_word(mavlink::common::MavType type);

/// The number whose decimal text is the shortest that a float reads back from: 0.15, not
/// 0.15000000596046448; an integer stays one. What is not finite is null.
nlohmann::json number_json(double value);
nlohmann::json parameters_json(const std::map<std::string, double>& parameters);

}  // namespace cas::casd
