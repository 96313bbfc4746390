// SPDX-License-Identifier: BSD-3-Clause
#include "casd/tlog/tlog_name.hpp"

#include <algorithm>
#include <array>
#include <ctime>

namespace cas::casd {
namespace {

constexpr std::size_t kLongestName = 100;  // a file's name has 255 bytes, with date and number

bool is_unprintable(char c) { return static_cast<unsigned char>(c) < 0x20 || c == 0x7F; }

}  // namespace

std::optional<std::string> tlog_name_fault(std::string_view name) {
  if (name.empty()) return "is empty";
  if (name.size() > kLongestName) return "has more than 100 characters";
  if (name.front() == '.') return "begins with a dot";
  if (name.find('/') != name.npos) return "has a slash";
  if (std::any_of(name.begin(), name.end(), is_unprintable)) return "has unprintable characters";
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

std::string tlog_file_name(std::string_view name, int number) {
  std::string file(name);
  if (number > 0) file += '.' + std::to_string(number);
  return file.append(kTlogExtension);
}

}  // namespace cas::casd
