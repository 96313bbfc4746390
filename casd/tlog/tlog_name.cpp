// SPDX-License-Identifier: BSD-3-Clause
#include "casd/tlog/tlog_name.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <ctime>
#include <system_error>
#include <utility>

#include "base/printable.hpp"

namespace cas::casd {
namespace {

constexpr std::size_t kLongestName = 100;  // a file's name has 255 bytes, with date and number

constexpr std::string_view kDatePattern = "dddd-dd-ddTdd-dd-ddZ";

/// "DATE-NAME.12.tlog" without its extension and number, and the number.
std::pair<std::string_view, int> without_number(std::string_view file) {
  file = file.substr(0, file.rfind('.'));
  const std::size_t dot = file.rfind('.');
  if (dot == file.npos) return {file, 0};
  int number = 0;
  const char* const end = file.data() + file.size();
  const auto [stop, error] = std::from_chars(file.data() + dot + 1, end, number);
  if (error != std::errc{} || stop != end) return {file, 0};
  return {file.substr(0, dot), number};
}

bool is_unprintable(std::string_view name) {
  return base::printable(name) != name || name.find('\t') != name.npos;
}

}  // namespace

std::optional<std::string> tlog_name_fault(std::string_view name) {
  if (name.empty()) return "is empty";
  if (name.size() > kLongestName) return "has more than 100 characters";
  if (name.front() == '.') return "begins with a dot";
  if (name.find('/') != name.npos) return "has a slash";
  if (is_unprintable(name)) return "has unprintable characters";
  return std::nullopt;
}

std::string_view bare_tlog_name(std::string_view name) {
  if (name.ends_with(kTlogExtension)) name.remove_suffix(kTlogExtension.size());
  return name;
}

std::string dated_tlog_name(std::chrono::seconds unix_time, std::string_view name) {
  const std::time_t time = unix_time.count();
  std::tm utc{};
  ::gmtime_r(&time, &utc);
  std::array<char, 64> text{};
  const std::size_t size =
      std::strftime(text.data(), text.size(), "%Y-%m-%dT%H-%M-%SZ", &utc);  // no colons: FAT
  std::string dated(text.data(), size);
  if (!name.empty()) dated += '-';
  return dated.append(name);
}

bool is_dated(std::string_view file) {
  if (file.size() <= kDatePattern.size()) return false;
  const auto matches = [](char c, char pattern) {
    return pattern == 'd' ? c >= '0' && c <= '9' : c == pattern;
  };
  if (!std::equal(kDatePattern.begin(), kDatePattern.end(), file.begin(),
                  [&](char pattern, char c) { return matches(c, pattern); })) {
    return false;
  }
  return file[kDatePattern.size()] == '-' || file[kDatePattern.size()] == '.';
}

bool older_tlog(std::string_view file, std::string_view other) {
  return without_number(file) < without_number(other);
}

std::string tlog_file_name(std::string_view name, int number) {
  std::string file(name);
  if (number > 0) file += '.' + std::to_string(number);
  return file.append(kTlogExtension);
}

}  // namespace cas::casd
