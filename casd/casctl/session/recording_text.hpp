// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <nlohmann/json.hpp>
#include <string>

namespace cas::casctl {

/// "recording into FILE: 120 packets", "recording PAUSED for 3 s: ...", "CANNOT RECORD: ...", ""
/// where nothing is recorded.
/// @param recording  as log.status tells it
std::string recording_text(const nlohmann::json& recording);

/// "logs of autopilots in FOLDER PAUSED for 3 s: ...", then a line for each vehicle.
/// @param logs  `autopilot_logs` of casd.status
std::string autopilot_logs_text(const nlohmann::json& logs);

}  // namespace cas::casctl
