// SPDX-License-Identifier: BSD-3-Clause
#include "hils/measure/column.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <nlohmann/json.hpp>

namespace cas::hils {

nlohmann::ordered_json column_json(std::span<const double> values, double step) {
  constexpr double kMost = 9e15;  // beyond it neighbouring integers are no doubles
  nlohmann::ordered_json differences = nlohmann::ordered_json::array();
  std::int64_t before = 0;
  for (const double value : values) {
    const std::int64_t next =
        std::isfinite(value) ? std::llround(std::clamp(value / step, -kMost, kMost)) : before;
    differences.push_back(next - before);
    before = next;
  }
  return {{"k", step}, {"d", std::move(differences)}};
}

}  // namespace cas::hils
