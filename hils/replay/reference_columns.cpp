// SPDX-License-Identifier: BSD-3-Clause
#include "hils/replay/reference_columns.hpp"

#include <nlohmann/json.hpp>

#include "hils/measure/column.hpp"

namespace cas::hils {

void ReferenceColumns::add(const std::array<double, 5>& row) {
  for (std::size_t i = 0; i < row.size(); ++i) columns_[i].push_back(row[i]);
}

nlohmann::ordered_json ReferenceColumns::json() const {
  if (columns_.front().empty()) return nullptr;
  return {{"t", column_json(columns_[0], 0.001)},
          {"x", column_json(columns_[1], 0.001)},
          {"y", column_json(columns_[2], 0.001)},
          {"z", column_json(columns_[3], 0.001)},
          {"yaw", column_json(columns_[4], 0.0005)}};
}

}  // namespace cas::hils
