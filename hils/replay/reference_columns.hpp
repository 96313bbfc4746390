// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <nlohmann/json_fwd.hpp>
#include <vector>

namespace cas::hils {

/// Where the vehicle was to be, as a record has it.
class ReferenceColumns {
 public:
  static constexpr double kPeriod_s = 0.05;

  /// @param row  time in s; x north, y east, z up in m, on the axes of the truth; yaw in rad
  void add(const std::array<double, 5>& row);

  /// A series for each column; null without any row.
  nlohmann::ordered_json json() const;

 private:
  std::array<std::vector<double>, 5> columns_;
};

}  // namespace cas::hils
