// SPDX-License-Identifier: BSD-3-Clause
#include "hils/measure/check_json.hpp"

#include <cmath>
#include <nlohmann/json.hpp>

namespace cas::hils {

using OrderedJson = nlohmann::ordered_json;

OrderedJson number_or_null(const std::optional<double>& value) {
  return value && std::isfinite(*value) ? OrderedJson(*value) : OrderedJson(nullptr);
}

OrderedJson checks_json(std::span<const LimitCheck> checks) {
  OrderedJson list = OrderedJson::array();
  for (const LimitCheck& check : checks) {
    list.push_back({{"what", check.what},
                    {"validity", check.kind == LimitCheck::Kind::kValidity},
                    {"value", number_or_null(check.value)},
                    {"bound", number_or_null(check.bound)},
                    {"margin", number_or_null(check.margin())},
                    {"least", check.sense == LimitCheck::Sense::kAtLeast},
                    {"unit", check.unit},
                    {"digits", check.digits},
                    {"found", check.found},
                    {"wanted", check.wanted},
                    {"judged", check.judged},
                    {"kept", check.kept}});
  }
  return list;
}

}  // namespace cas::hils
