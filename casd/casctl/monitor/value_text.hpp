// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>

namespace cas::casctl {

/// "12", "3.4k", "1.2M": five columns at most.
std::string short_count(std::uint64_t n);
/// "0.4 s", "12 s", "3 min".
std::string age_text(double age_s);
/// A value as casd tells it: of an array its first four elements.
std::string value_text(const nlohmann::json& value);

}  // namespace cas::casctl
