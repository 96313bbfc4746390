// SPDX-License-Identifier: BSD-3-Clause
#include "casd/casctl/monitor/value_text.hpp"

#include <algorithm>

#include "casd/casctl/session/table.hpp"

namespace cas::casctl {

std::string short_count(std::uint64_t n) {
  const auto value = static_cast<double>(n);
  if (n < 10'000) return std::to_string(n);
  if (n < 1'000'000) return fixed(value / 1e3, n < 100'000 ? 1 : 0) + "k";
  if (n < 1'000'000'000) return fixed(value / 1e6, n < 100'000'000 ? 1 : 0) + "M";
  return fixed(value / 1e9, 1) + "G";
}

std::string age_text(double age_s) {
  if (age_s < 10) return fixed(std::max(age_s, 0.0), 1) + " s";
  if (age_s < 600) return fixed(age_s, 0) + " s";
  if (age_s < 7200) return fixed(age_s / 60, 0) + " min";
  return fixed(age_s / 3600, 1) + " h";
}

std::string value_text(const nlohmann::json& value) {
  if (value.is_string()) return value.get<std::string>();
  if (value.is_number_float()) {
    char text[32];
    std::snprintf(text, sizeof text, "%.6g", value.get<double>());
    return text;
  }
  if (!value.is_array()) return value.is_null() ? "nan" : value.dump();
  constexpr std::size_t kMost = 4;
  std::string text;
  for (std::size_t i = 0; i < std::min(value.size(), kMost); ++i) {
    text += (text.empty() ? "" : " ") + value_text(value[i]);
  }
  if (value.size() > kMost) text += " and " + std::to_string(value.size() - kMost) + " more";
  return text;
}

}  // namespace cas::casctl
