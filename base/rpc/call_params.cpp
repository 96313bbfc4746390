// SPDX-License-Identifier: BSD-3-Clause
#include "base/rpc/call_params.hpp"

#include <cmath>
#include <string_view>
#include <vector>

#include "base/suggestion.hpp"

namespace cas::base::rpc {
namespace {

bool within(double value, std::int64_t low, std::int64_t high) {
  return value >= static_cast<double>(low) && value <= static_cast<double>(high);
}

std::string from_to(std::int64_t low, std::int64_t high) {
  return " from " + std::to_string(low) + " to " + std::to_string(high);
}

}  // namespace

CallParams::CallParams(const Json& params) : params_(params) {
  if (params_.is_null()) params_ = Json::object();
  if (!params_.is_object()) throw BadParams("parameters are given by name, in an object");
}

/// The value of a key; null counts as absent.
const Json* CallParams::find(const std::string& key) {
  asked_.insert(key);
  const auto found = params_.find(key);
  return found == params_.end() || found->is_null() ? nullptr : &*found;
}

void CallParams::missing(const std::string& key, const std::string& kind) const {
  std::vector<std::string_view> others;
  for (auto item = params_.begin(); item != params_.end(); ++item) {
    if (!asked_.contains(item.key())) others.push_back(item.key());
  }
  const std::string near = nearest_word(key, others);
  throw BadParams("\"" + key + "\" is missing: " + kind +
                  (near.empty() ? "" : "; \"" + near + "\" is no parameter of this method"));
}

std::optional<double> CallParams::optional_number(const std::string& key) {
  const Json* value = find(key);
  if (value == nullptr) return std::nullopt;
  if (!value->is_number()) throw BadParams("\"" + key + "\" must be a number");
  return value->get<double>();
}

double CallParams::number(const std::string& key) {
  const std::optional<double> value = optional_number(key);
  if (!value) missing(key, "a number");
  return *value;
}

double CallParams::number(const std::string& key, std::int64_t low, std::int64_t high) {
  const double value = number(key);
  if (within(value, low, high)) return value;
  throw BadParams("\"" + key + "\" must be a number" + from_to(low, high));
}

std::optional<std::int64_t> CallParams::optional_integer(const std::string& key, std::int64_t low,
                                                         std::int64_t high) {
  const std::optional<double> value = optional_number(key);
  if (!value) return std::nullopt;
  if (*value != std::floor(*value) || !within(*value, low, high)) {
    throw BadParams("\"" + key + "\" must be an integer" + from_to(low, high));
  }
  return static_cast<std::int64_t>(*value);
}

std::int64_t CallParams::integer(const std::string& key, std::int64_t low, std::int64_t high) {
  const std::optional<std::int64_t> value = optional_integer(key, low, high);
  if (!value) missing(key, "an integer");
  return *value;
}

std::optional<std::string> CallParams::optional_text(const std::string& key) {
  const Json* value = find(key);
  if (value == nullptr) return std::nullopt;
  if (!value->is_string()) throw BadParams("\"" + key + "\" must be a string");
  return value->get<std::string>();
}

std::string CallParams::text(const std::string& key) {
  const std::optional<std::string> value = optional_text(key);
  if (!value) missing(key, "a string");
  return *value;
}

bool CallParams::flag(const std::string& key) {
  const Json* value = find(key);
  if (value == nullptr) return false;
  if (!value->is_boolean()) throw BadParams("\"" + key + "\" must be true or false");
  return value->get<bool>();
}

Json CallParams::object(const std::string& key) {
  const Json* value = find(key);
  if (value == nullptr) missing(key, "an object");
  if (!value->is_object()) throw BadParams("\"" + key + "\" is no object");
  return *value;
}

Json CallParams::value(const std::string& key) {
  const Json* found = find(key);
  return found == nullptr ? Json() : *found;
}

void CallParams::finish() const {
  for (const auto& item : params_.items()) {
    if (!asked_.contains(item.key())) {
      throw BadParams("\"" + item.key() + "\" is no parameter of this method");
    }
  }
}

}  // namespace cas::base::rpc
