// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <limits>
#include <optional>
#include <string>
#include <tuple>
#include <type_traits>
#include <utility>

#include "hils/flight/incident_kind.hpp"
#include "hils/measure/strike_response.hpp"

namespace cas::hils {

/// Outputs that hold a field of StrikeResponse.
enum class StrikeOutput {
  kCsv,      ///< campaign.csv, campaign.json and journals
  kJson,     ///< campaign.json and journals
  kJournal,  ///< journals only
};

/// A field of StrikeResponse under its name in all outputs.
template <class Value>
struct StrikeField {
  const char* key;
  Value StrikeResponse::*member;
  StrikeOutput output = StrikeOutput::kCsv;
  double absent = std::numeric_limits<double>::quiet_NaN();  ///< read back from null
};

template <class Value, class... Rest>
StrikeField(const char*, Value StrikeResponse::*, Rest...) -> StrikeField<Value>;

/// In the order of campaign.csv and campaign.json.
inline constexpr std::tuple kStrikeFields{
    StrikeField{"strike_s", &StrikeResponse::strike_s},
    StrikeField{"detected_s", &StrikeResponse::detected_s},
    StrikeField{"detected_by", &StrikeResponse::detected_by},
    StrikeField{"reacted_s", &StrikeResponse::reacted_s},
    StrikeField{"reaction", &StrikeResponse::reaction},
    StrikeField{"farthest_m", &StrikeResponse::farthest_m, StrikeOutput::kCsv,
                std::numeric_limits<double>::infinity()},
    StrikeField{"peak_tilt_deg", &StrikeResponse::peak_tilt_deg, StrikeOutput::kCsv,
                std::numeric_limits<double>::infinity()},
    StrikeField{"incident", &StrikeResponse::incident},
    StrikeField{"crashed", &StrikeResponse::crashed},
    StrikeField{"terminated", &StrikeResponse::terminated, StrikeOutput::kJson},
    StrikeField{"completed", &StrikeResponse::completed},
    StrikeField{"at_rest", &StrikeResponse::at_rest},
    StrikeField{"rest_m", &StrikeResponse::rest_m},
    StrikeField{"armed_after", &StrikeResponse::armed_after, StrikeOutput::kJson},
    StrikeField{"fault", &StrikeResponse::fault, StrikeOutput::kJournal},
    StrikeField{"no_verdict", &StrikeResponse::no_verdict, StrikeOutput::kJournal},
    StrikeField{"armed_before", &StrikeResponse::armed_before, StrikeOutput::kJournal},
    StrikeField{"tried_to_arm", &StrikeResponse::tried_to_arm, StrikeOutput::kJournal},
    StrikeField{"in_air", &StrikeResponse::in_air, StrikeOutput::kJournal},
    StrikeField{"left_world", &StrikeResponse::left_world, StrikeOutput::kJournal}};

/// Calls `use` with each field of an output.
template <class Use>
void for_each_strike_field(StrikeOutput output, const Use& use) {
  const auto use_if = [&](const auto& field) {
    if (field.output <= output) use(field);
  };
  std::apply([&](const auto&... field) { (use_if(field), ...); }, kStrikeFields);
}

/// The value of a field. Null: no incident, or a number that is absent or not finite.
template <class Json, class Value>
Json field_json(const StrikeResponse& response, const StrikeField<Value>& field) {
  const Value& value = response.*field.member;
  if constexpr (std::is_same_v<Value, std::optional<IncidentKind>>) {
    return value ? Json(to_string(*value)) : Json(nullptr);
  } else if constexpr (std::is_same_v<Value, std::optional<std::string>>) {
    return value.value_or("");
  } else if constexpr (std::is_same_v<Value, double> ||
                       std::is_same_v<Value, std::optional<double>>) {
    const std::optional<double> number = value;
    return number && std::isfinite(*number) ? Json(*number) : Json(nullptr);
  } else {
    return value;
  }
}

/// Sets a field from field_json(). @throws nlohmann::json::exception for a value of another type
template <class Json, class Value>
void read_field(const Json& value, const StrikeField<Value>& field, StrikeResponse& response) {
  Value& to = response.*field.member;
  if constexpr (std::is_same_v<Value, double>) {
    to = value.is_null() ? field.absent : value.template get<double>();
  } else if constexpr (std::is_same_v<Value, std::optional<double>>) {
    if (!value.is_null()) to = value.template get<double>();
  } else if constexpr (std::is_same_v<Value, std::optional<IncidentKind>>) {
    if (!value.is_null()) to = kIncidentWords.find(value.template get<std::string>());
  } else if constexpr (std::is_same_v<Value, std::optional<std::string>>) {
    if (auto text = value.template get<std::string>(); !text.empty()) to = std::move(text);
  } else {
    to = value.template get<Value>();
  }
}

}  // namespace cas::hils
