// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <nlohmann/json.hpp>
#include <string>

namespace cas::casctl {

/// Where a link is bound and where it sends: "127.0.0.1:49428 -> 10.0.0.2:14550"; the reason while
/// it is down.
/// @param link  as casd.status tells it
std::string endpoint_text(const nlohmann::json& link);

}  // namespace cas::casctl
