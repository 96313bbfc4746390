// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>

#include "base/rpc/call_params.hpp"
#include "base/rpc/server.hpp"
#include "mavlink/common/enums.hpp"
#include "mavlink_gen/json/message_codec.hpp"

namespace cas::casd {

using base::rpc::BadParams;
using base::rpc::CallParams;

/// Weight of a call that changes something; one that only looks has 1 (Server::add_method). Clients
/// that watch must not delay those that fly.
inline constexpr double kWeightOfChange = 0.25;

/// A MAVLink message by its name or id. @throws BadParams
std::uint32_t message_id(const nlohmann::json& message);

/// A method that looks only, and answers at once.
void add_look(base::rpc::Server& server, const std::string& name,
              std::function<nlohmann::json(CallParams&)> look);

/// Called for each call. @param refusal  nullopt: it came to its end
using Audit =
    std::function<void(const std::string& client, const std::string& method,
                       const nlohmann::json& params, const std::optional<std::string>& refusal)>;
/// A method that changes something, and answers at once or later.
void add_change(base::rpc::Server& server, const std::string& name, Audit audit,
                std::function<void(CallParams&, const base::rpc::Reply&)> change);

/// "ACCEPTED", "DENIED", ...: the MAV_RESULT names without their prefix.
std::string result_word(mavlink::common::MavResult result);
/// "emergency" ... "debug", by syslog's names.
std::string_view severity_word(mavlink::common::MavSeverity severity);
/// "quadrotor", "hexarotor", ..., "type 27".
std::string type_word(mavlink::common::MavType type);

using mav::services::number_json;
nlohmann::json parameters_json(const std::map<std::string, double>& parameters);

}  // namespace cas::casd
