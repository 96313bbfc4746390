// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "hils/measure/flight_changes.hpp"
#include "hils/report/document.hpp"

namespace cas::hils {

/// A note on a flight with outside acts, a table of changed parameters (when, by whom, of which
/// loop, old -> new) and one of acts; nothing where there are none.
/// @param who  in front of them: "left: ", or nothing
void add_changes(const FlightChanges& changes, const std::string& who, Document& report);

/// Adds `from_outside`, `changes` and `acts`.
void add_changes(const FlightChanges& changes, nlohmann::ordered_json& summary);

}  // namespace cas::hils
