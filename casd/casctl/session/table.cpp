// SPDX-License-Identifier: BSD-3-Clause
#include "casd/casctl/session/table.hpp"

#include <algorithm>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <utility>

#include "casd/casctl/session/printable.hpp"

namespace cas::casctl {
namespace {

bool numeric(const std::string& cell) {
  return cell.empty() || cell == "-" ||
         cell.find_first_not_of("0123456789.-+%") == std::string::npos;
}

}  // namespace

void Table::add(std::vector<std::string> row) {
  for (std::string& cell : row) cell = printable(std::move(cell));
  rows_.push_back(std::move(row));
}

void Table::print(std::ostream& out) const {
  const std::size_t columns = rows_.front().size();
  std::vector<std::size_t> widths(columns, 0);
  std::vector<bool> right(columns, rows_.size() > 1);
  for (std::size_t r = 0; r < rows_.size(); ++r) {
    for (std::size_t c = 0; c < columns; ++c) {
      widths[c] = std::max(widths[c], rows_[r][c].size());
      if (r > 0 && !numeric(rows_[r][c])) right[c] = false;
    }
  }
  for (const auto& row : rows_) {
    std::string line;
    for (std::size_t c = 0; c < columns; ++c) {
      const std::string pad(widths[c] - row[c].size(), ' ');
      if (c > 0) line += "  ";
      line += right[c] ? pad + row[c] : row[c] + pad;
    }
    line.erase(line.find_last_not_of(' ') + 1);
    out << line << '\n';
  }
}

std::string fixed(double value, int decimals) {
  char text[48];
  std::snprintf(text, sizeof text, "%.*f", decimals, value);
  return text;
}

std::string count_text(const nlohmann::json& object, const char* key) {
  const auto found = object.find(key);
  return found == object.end() || !found->is_number() ? "-" : found->dump();
}

std::string duration_text(double seconds) {
  if (seconds < 120) return fixed(seconds, 1) + " s";
  if (seconds < 7200) return fixed(seconds / 60, 0) + " min";
  constexpr double kDay_s = 86400;
  constexpr double kYear_s = 365.25 * kDay_s;
  if (seconds < 2 * kDay_s) return fixed(seconds / 3600, 1) + " h";
  if (seconds < 2 * kYear_s) return fixed(seconds / kDay_s, 1) + " days";
  return fixed(seconds / kYear_s, 1) + " years";
}

std::string stream_text(const nlohmann::json& future) {
  return std::to_string(future.value("system", 0)) + "/" +
         std::to_string(future.value("component", 0)) + " (signing link " +
         std::to_string(future.value("link_id", 0)) + ")";
}

}  // namespace cas::casctl
