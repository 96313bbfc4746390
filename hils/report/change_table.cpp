// SPDX-License-Identifier: BSD-3-Clause
#include "hils/report/change_table.hpp"

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "casd/station/services.hpp"
#include "hils/report/document.hpp"
#include "hils/report/number_text.hpp"

namespace cas::hils {

void add_changes(const FlightChanges& changes, const std::string& who, Document& report) {
  if (changes.from_outside()) {
    report.paragraph(who +
                     "Somebody acted from outside in this flight: it is not the scenario alone.");
  }
  Rows parameters{{"Time s", "by", "loop", "parameter", "old -> new"}};
  for (const ParameterChange& change : changes.parameters) {
    parameters.push_back(
        {fixed(change.time_s, 2), change.by, change.loop.empty() ? "-" : change.loop,
         change.parameter,
         fmt::format("{} -> {}", change.before ? casd::number_text(*change.before) : "?",
                     casd::number_text(change.after))});
  }
  if (parameters.size() > 1) report.table(who + "Changed in flight", parameters, {}, Align::kLeft);
  Rows acts{{"Time s", "by", "what", "times"}};
  for (const OutsideAct& act : changes.acts) {
    acts.push_back({fixed(act.time_s, 2), act.by, act.what, fmt::format("{}", act.times)});
  }
  if (acts.size() > 1) report.table(who + "Commands from outside", acts, {}, Align::kLeft);
}

void add_changes(const FlightChanges& changes, nlohmann::ordered_json& summary) {
  using Json = nlohmann::ordered_json;
  // 0.6, not the 0.6000000238418579 that a float of it is.
  const auto decimal = [](double value) -> Json {
    if (!std::isfinite(value)) return nullptr;
    return Json::parse(casd::number_text(value), nullptr, false);
  };
  summary["from_outside"] = changes.from_outside();
  summary["changes"] = Json::array();
  for (const ParameterChange& change : changes.parameters) {
    summary["changes"].push_back({{"time_s", change.time_s},
                                  {"by", change.by},
                                  {"parameter", change.parameter},
                                  {"loop", change.loop},
                                  {"old", change.before ? decimal(*change.before) : Json(nullptr)},
                                  {"new", decimal(change.after)},
                                  {"from_outside", change.from_outside}});
  }
  summary["acts"] = Json::array();
  for (const OutsideAct& act : changes.acts) {
    summary["acts"].push_back(
        {{"time_s", act.time_s}, {"by", act.by}, {"what", act.what}, {"times", act.times}});
  }
}

}  // namespace cas::hils
