// SPDX-License-Identifier: BSD-3-Clause
#include "casd/casctl/verbs/param_file.hpp"

#include <fmt/format.h>
#include <algorithm>
#include <charconv>
#include <cstdint>
#include <optional>
#include <stdexcept>
#include <system_error>

#include "base/byte_order_mark.hpp"
#include "base/text.hpp"

namespace cas::casctl {
namespace {

constexpr std::string_view kBlanks = " \t\r";
constexpr std::size_t kLongestName = 16;  // bytes of PARAM_SET's param_id
/// ArduPilot's default files mark a value that the vehicle must not change.
constexpr std::string_view kReadOnlyMark = "@READONLY";

template <class T>
std::optional<T> whole(std::string_view text, int base = 10) {
  T number{};
  const char* const end = text.data() + text.size();
  const auto [rest, fault] = std::from_chars(text.data(), end, number, base);
  if (fault != std::errc() || rest != end) return std::nullopt;
  return number;
}

std::optional<double> decimal(std::string_view text) {
  double number = 0;
  const char* const end = text.data() + text.size();
  const auto [rest, fault] = std::from_chars(text.data(), end, number);
  if (fault != std::errc() || rest != end) return std::nullopt;
  return number;
}

/// A number, decimal or after 0x, with or without a sign; "nan" and "inf" are some, too.
std::optional<double> value_of(std::string_view text) {
  const bool negative = text.starts_with('-');
  if (negative || text.starts_with('+')) text.remove_prefix(1);
  if (text.empty() || text.front() == '-' || text.front() == '+') return std::nullopt;
  std::optional<double> number;
  if (text.starts_with("0x") || text.starts_with("0X")) {
    const auto bits = whole<std::uint64_t>(text.substr(2), 16);
    if (bits) number = static_cast<double>(*bits);
  } else {
    number = decimal(text);
  }
  if (number && negative) number = -*number;
  return number;
}

bool is_name(std::string_view text) {
  const auto belongs = [](char c) {
    return (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '_' ||
           c == '-' || c == '.';
  };
  return !text.empty() && text.size() <= kLongestName &&
         std::all_of(text.begin(), text.end(), belongs);
}

std::vector<std::string_view> columns_of(std::string_view text) {
  std::vector<std::string_view> columns;
  for (text = base::trimmed(text); !text.empty(); text = base::trimmed(text)) {
    const std::size_t length = std::min(text.find_first_of(kBlanks), text.size());
    columns.push_back(text.substr(0, length));
    text.remove_prefix(length);
  }
  return columns;
}

/// system, component, name, value and, in newer files, type.
std::optional<ParamWish> row_of_columns(const std::vector<std::string_view>& columns) {
  if (columns.size() != 4 && columns.size() != 5) return std::nullopt;
  const auto system = whole<std::uint8_t>(columns[0]);
  const auto component = whole<std::uint8_t>(columns[1]);
  const auto value = value_of(columns[3]);
  if (!system || !component || !is_name(columns[2]) || !value) return std::nullopt;
  if (columns.size() == 5 && !whole<unsigned>(columns[4])) return std::nullopt;
  return ParamWish{std::string(columns[2]), *value, *component};
}

/// NAME VALUE or NAME,VALUE.
std::optional<ParamWish> pair_of(std::string_view line) {
  if (line.ends_with(kReadOnlyMark))
    line = base::trimmed(line.substr(0, line.size() - kReadOnlyMark.size()));
  const std::size_t end = line.find_first_of(" \t\r,");
  if (end == std::string_view::npos) return std::nullopt;
  const std::string_view name = line.substr(0, end);
  std::string_view rest = base::trimmed(line.substr(end));
  if (rest.starts_with(',')) rest = base::trimmed(rest.substr(1));
  const auto value = value_of(rest);
  if (!is_name(name) || !value) return std::nullopt;
  return ParamWish{std::string(name), *value, 0};
}

/// Takes the next line off `text`; it ends with LF, CR LF or CR.
std::string_view take_line(std::string_view& text) {
  const std::size_t end = text.find_first_of("\r\n");
  const std::string_view line = text.substr(0, end);
  if (end == std::string_view::npos) {
    text = {};
  } else {
    text.remove_prefix(end + (text.substr(end).starts_with("\r\n") ? 2 : 1));
  }
  return line;
}

}  // namespace

std::vector<ParamWish> parse_param_file(std::string_view text, const std::string& file) {
  if (text.starts_with("\xff\xfe") || text.starts_with("\xfe\xff")) {
    throw std::runtime_error(file + " is in UTF-16; save it as UTF-8");
  }
  text = base::without_byte_order_mark(text);
  std::vector<ParamWish> wishes;
  for (int number = 1; !text.empty(); ++number) {
    const std::string_view whole_line = take_line(text);
    const std::string_view line = base::trimmed(whole_line.substr(0, whole_line.find('#')));
    if (line.empty()) continue;
    std::optional<ParamWish> wish = row_of_columns(columns_of(line));
    if (!wish) wish = pair_of(line);
    if (!wish) {
      throw std::runtime_error(
          fmt::format("{}:{}: expected NAME VALUE, NAME,VALUE or QGroundControl's columns "
                      "(system, component, name, value, type), with a decimal point or 0x",
                      file, number));
    }
    wishes.push_back(*std::move(wish));
  }
  if (wishes.empty()) throw std::runtime_error(file + " holds no parameter");
  return wishes;
}

}  // namespace cas::casctl
