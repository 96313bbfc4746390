// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <string>

#include "base/rpc/message.hpp"

namespace cas::base::rpc {

/// Reads the named parameters of one call. Missing, mistyped and unknown ones throw BadParams.
class CallParams {
 public:
  explicit CallParams(const Json& params);

  double number(const std::string& key);
  std::optional<double> optional_number(const std::string& key);
  /// A number in [low, high].
  double number(const std::string& key, std::int64_t low, std::int64_t high);
  /// An integer in [low, high].
  std::int64_t integer(const std::string& key, std::int64_t low, std::int64_t high);
  std::optional<std::int64_t> optional_integer(const std::string& key, std::int64_t low,
                                               std::int64_t high);
  std::string text(const std::string& key);
  std::optional<std::string> optional_text(const std::string& key);
  /// Absent is false.
  bool flag(const std::string& key);
  /// An object.
  Json object(const std::string& key);
  /// The value itself, null when absent.
  Json value(const std::string& key);

  /// Refuses keys that were not read.
  void finish() const;

 private:
  const Json* find(const std::string& key);
  /// Throws; names a parameter of nearly the same spelling, if there is one.
  [[noreturn]] void missing(const std::string& key, const std::string& kind) const;

  Json params_;
  std::set<std::string> asked_;
};

}  // namespace cas::base::rpc
