// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "hils/measure/figure_table.hpp"

namespace cas::hils {

/// The value of a figure; null: it was not measured, or is no number.
template <class Json, class Of>
Json figure_json(const Figure<Of>& row, const Of& of) {
  const std::optional<double> value = row.get(of);
  if (!value || !std::isfinite(*value)) return nullptr;
  return row.is_count() ? Json(static_cast<std::uint64_t>(*value)) : Json(*value);
}

/// Puts the figures of a part at their places in summary.json. A block none of whose figures was
/// measured is null.
template <class Json, class Of>
void put_figures(const std::vector<Figure<Of>>& table, typename Figure<Of>::Part part, const Of& of,
                 Json& summary) {
  for (const Figure<Of>& row : table) {
    if (row.part != part) continue;
    std::string path = "/" + row.place();
    std::ranges::replace(path, '.', '/');
    const typename Json::json_pointer place(path);
    Json value = figure_json<Json>(row, of);
    Json& block = summary[place.parent_pointer()];
    if (!value.is_null() || block.is_object()) block[place.back()] = std::move(value);
  }
}

}  // namespace cas::hils
