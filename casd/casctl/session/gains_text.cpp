// SPDX-License-Identifier: BSD-3-Clause
#include "casd/casctl/session/gains_text.hpp"

#include <nlohmann/json.hpp>
#include <utility>

namespace cas::casctl {

using nlohmann::json;

std::string change_text(const json& before, const json& now) {
  return before.is_number() && before != now ? before.dump() + " -> " + now.dump() : now.dump();
}

std::string gains_text(const json& gains) {
  std::string text = gains.value("loop", "?");
  const json before = gains.value("before", json::object());
  const char* separator = ": ";
  for (const auto& [key, letter] : {std::pair{"p", "P "}, {"i", "I "}, {"d", "D "}}) {
    if (!gains.contains(key)) continue;
    text += separator + std::string(letter) + change_text(before.value(key, json()), gains[key]);
    separator = ", ";
  }
  return text;
}

std::string param_text(const json& parameter) {
  return parameter.value("name", "?") + " = " +
         change_text(parameter.value("before", json()), parameter.value("value", json()));
}

}  // namespace cas::casctl
