// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <ostream>
#include <string>
#include <vector>

namespace cas::casctl {

/// A plain text table: columns as wide as their widest cell, numbers to the right.
class Table {
 public:
  explicit Table(std::vector<std::string> header) : rows_{std::move(header)} {}
  /// Control characters in it are shown as `?`.
  void add(std::vector<std::string> row);
  bool empty() const { return rows_.size() == 1; }
  void print(std::ostream& out) const;

 private:
  std::vector<std::vector<std::string>> rows_;
};

/// A number with a fixed count of decimals.
std::string fixed(double value, int decimals);
/// A number of an object; "-": it has none.
std::string count_text(const nlohmann::json& object, const char* key);
/// A duration in words of one unit: "0.4 s", "12 min", "3.1 h", "9.5 days", "10.0 years".
std::string duration_text(double seconds);
/// The signer, from `future` of link.list: "1/200 (signing link 3)".
std::string stream_text(const nlohmann::json& future);

}  // namespace cas::casctl
