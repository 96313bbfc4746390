// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

namespace cas::casctl {

/// "1.5 -> 1.2", or "1.2" if unchanged, or if the old value is unknown (null).
std::string change_text(const nlohmann::json& before, const nlohmann::json& now);

/// An answer of gain.set or gain.get: "rollrate: P 0.15 -> 0.16, I 0.2, D 0.003".
std::string gains_text(const nlohmann::json& gains);

/// An answer of param.set or param.get: "MC_ROLL_P = 6.5 -> 7".
std::string param_text(const nlohmann::json& parameter);

}  // namespace cas::casctl
