// SPDX-License-Identifier: BSD-3-Clause
#include "hils/tune/eval_line.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <utility>

#include "base/error.hpp"
#include "base/suggestion.hpp"

namespace cas::hils {

namespace {

using OrderedJson = nlohmann::ordered_json;

constexpr std::size_t kLongestId = 256;
constexpr const char* kWrongId = "'id' is a number, a word, true or false, of at most 256 bytes";

std::string line_of(const OrderedJson& json) {
  return json.dump(-1, ' ', false, OrderedJson::error_handler_t::replace) + "\n";
}

OrderedJson number(double value) {
  return std::isfinite(value) ? OrderedJson(value) : OrderedJson(nullptr);
}

void read_parameters(const OrderedJson& values, const std::vector<Parameter>& known,
                     EvalRequest& request) {
  if (!values.is_object()) throw base::ConfigError("'parameters' is a map of names and values");
  std::vector<std::string> names;
  names.reserve(known.size());
  for (const Parameter& each : known) names.push_back(each.name);
  for (const auto& [name, value] : values.items()) {
    if (std::ranges::find(names, name) == names.end()) {
      throw base::ConfigError("the study has no parameter '" + name + "'" +
                              base::did_you_mean(name, names));
    }
    if (value.is_structured() || value.is_null()) {
      throw base::ConfigError("'" + name + "' takes a number, a word, true or false");
    }
    request.parameters.emplace_back(name, value.dump());  // JSON is YAML
  }
}

void read(const OrderedJson& json, const std::vector<Parameter>& known, EvalRequest& request) {
  if (!json.is_object()) throw base::ConfigError("the line is no JSON map");
  for (const auto& [key, value] : json.items()) {
    if (key == "parameters") {
      read_parameters(value, known, request);
    } else if (key == "seed") {
      if (!value.is_number_unsigned()) throw base::ConfigError("'seed' is a whole number from 0");
      request.seed = value.get<std::uint64_t>();
    } else if (key != "id") {
      throw base::ConfigError("there is no key '" + key + "'; there are id, parameters and seed");
    }
  }
}

}  // namespace

EvalRequest EvalRequest::parse(std::string_view line, const std::vector<Parameter>& parameters,
                               std::uint64_t seed) {
  EvalRequest request{.seed = seed};
  const OrderedJson json = OrderedJson::parse(line, nullptr, false);
  try {
    if (json.is_object() && json.contains("id")) {
      if (json["id"].is_structured()) throw base::ConfigError(kWrongId);
      std::string id = json["id"].dump(-1, ' ', false, OrderedJson::error_handler_t::replace);
      if (id.size() > kLongestId) throw base::ConfigError(kWrongId);
      request.id = std::move(id);
    }
    read(json, parameters, request);
  } catch (const base::ConfigError& error) {
    request.error = error.what();
  }
  return request;
}

std::string eval_answer(const EvalRequest& request, const RowResult& result,
                        const std::vector<std::string>& figures) {
  OrderedJson json;
  json["id"] = OrderedJson::parse(request.id);
  json["outcome"] = to_string(result.outcome);
  const auto figure = [&](std::size_t i) {
    return i < result.figures.size() ? number(result.figures[i]) : OrderedJson(nullptr);
  };
  json["up"] = is_judged(result.outcome) ? figure(kUpFigure) : OrderedJson(nullptr);
  json["cause"] = result.cause;
  json["incident"] = result.incident;
  json["warnings"] = result.warnings;
  json["seed"] = request.seed;
  json["figures"] = OrderedJson::object();
  for (std::size_t i = 0; i < figures.size(); ++i) json["figures"][figures[i]] = figure(i);
  json["truth_sha256"] = result.truth_sha256;
  json["wall_s"] = result.machine.wall_s;
  return line_of(json);
}

std::string eval_error(const EvalRequest& request, const std::string& sentence) {
  OrderedJson json;
  json["id"] = OrderedJson::parse(request.id);
  json["error"] = sentence;
  return line_of(json);
}

std::string eval_description(const Study& study, const std::vector<std::string>& figures) {
  OrderedJson json;
  json["schema"] = kEvalSchema;
  json["study"] = study.name;
  json["parameters"] = OrderedJson::array();
  for (const Parameter& each : study.parameters) {
    OrderedJson own{{"name", each.name}, {"keys", each.keys}};
    if (!each.values.empty()) own["values"] = each.values;
    if (each.distribution) {
      if (each.distribution->least) own["least"] = *each.distribution->least;
      if (each.distribution->most) own["most"] = *each.distribution->most;
      own["log"] = each.distribution->kind == Distribution::Kind::kLog;
      own["whole"] = each.whole;
    }
    json["parameters"].push_back(std::move(own));
  }
  json["figures"] = figures;
  return line_of(json);
}

}  // namespace cas::hils
