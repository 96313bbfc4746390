// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "hils/measure/flight_changes.hpp"

namespace cas::hils {

/// Note below the verdict of a flight with outside acts.
inline constexpr std::string_view kOutsideNote =
    "Somebody acted from outside in this flight: it is not the scenario alone.";

/// A heading and a row for each: when, by whom, which parameter of which loop, old -> new.
std::vector<std::vector<std::string>> parameter_rows(const FlightChanges& changes);
/// A heading and a row for each: time, operator, act, number of times.
std::vector<std::vector<std::string>> act_rows(const FlightChanges& changes);

/// Both in aligned columns, below the note; empty where nothing was changed.
std::string changes_text(const FlightChanges& changes);

/// Adds `from_outside`, `changes` and `acts`.
void add_changes(const FlightChanges& changes, nlohmann::ordered_json& summary);

}  // namespace cas::hils
