// SPDX-License-Identifier: BSD-3-Clause
#include "hils/measure/csv_row.hpp"

#include <algorithm>
#include <charconv>

#include "base/error.hpp"

namespace cas::hils {

std::optional<std::vector<double>> parse_csv_row(std::string_view line) {
  std::vector<double> values;
  values.reserve(1 + static_cast<std::size_t>(std::ranges::count(line, ',')));
  while (true) {
    double value = 0;
    const auto [end, error] = std::from_chars(line.data(), line.data() + line.size(), value);
    if (error != std::errc{}) return std::nullopt;
    values.push_back(value);
    line.remove_prefix(static_cast<std::size_t>(end - line.data()));
    if (line.empty()) return values;
    if (line.front() != ',') return std::nullopt;
    line.remove_prefix(1);
  }
}

bool next_line(std::istream& in, std::string& line, const std::filesystem::path& file) {
  if (std::getline(in, line)) return true;
  if (in.bad()) throw base::ConfigError(file.string() + ": cannot be read to its end");
  return false;
}

}  // namespace cas::hils
