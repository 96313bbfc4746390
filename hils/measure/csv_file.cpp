// SPDX-License-Identifier: BSD-3-Clause
#include "hils/measure/csv_file.hpp"

#include <fmt/format.h>

#include <charconv>
#include <system_error>
#include <utility>

#include "base/error.hpp"

namespace cas::hils {

CsvFile::CsvFile(std::filesystem::path file)
    : file_(std::move(file)), in_(file_), is_there_(in_.is_open()) {
  if (read_line()) header_ = line_;
}

std::span<const double> CsvFile::next(std::size_t columns) {
  row_.clear();
  if (!read_line()) return {};
  ++number_;
  if (!parse_line() || row_.size() < columns) {
    throw base::ConfigError(
        fmt::format("{}:{}: not a row of {}", file_.string(), number_, file_.filename().string()));
  }
  return row_;
}

bool CsvFile::read_line() {
  if (std::getline(in_, line_)) return true;
  if (in_.bad()) throw base::ConfigError(file_.string() + ": cannot be read to its end");
  return false;
}

/// @return false when anything but numbers between commas stands in the line
bool CsvFile::parse_line() {
  const char* at = line_.data();
  const char* const end = at + line_.size();
  while (true) {
    double value = 0;
    const auto [after, error] = std::from_chars(at, end, value);
    if (error != std::errc{}) return false;
    row_.push_back(value);
    if (after == end) return true;
    if (*after != ',') return false;
    at = after + 1;
  }
}

}  // namespace cas::hils
