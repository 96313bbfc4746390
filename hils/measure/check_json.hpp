// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <span>

#include "hils/measure/limit_check.hpp"

namespace cas::hils {

/// Null where there is none, or no number.
nlohmann::ordered_json number_or_null(const std::optional<double>& value);

/// The checks of a run, in the page's format (docs/develop/web_protocol.md, "Runs").
nlohmann::ordered_json checks_json(std::span<const LimitCheck> checks);

}  // namespace cas::hils
