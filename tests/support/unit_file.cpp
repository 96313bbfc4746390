// SPDX-License-Identifier: BSD-3-Clause
#include "tests/support/unit_file.hpp"

#include <cctype>
#include <fstream>
#include <stdexcept>

namespace cas::test {
namespace {

std::string trimmed(const std::string& text) {
  const std::size_t begin = text.find_first_not_of(" \t");
  if (begin == std::string::npos) return "";
  return text.substr(begin, text.find_last_not_of(" \t") - begin + 1);
}

double seconds_of(const std::string& unit) {
  static const std::map<std::string, double> kUnits = {{"us", 1e-6},  {"ms", 1e-3}, {"", 1},
                                                       {"s", 1},      {"sec", 1},   {"m", 60},
                                                       {"min", 60.0}, {"h", 3600}};
  const auto found = kUnits.find(unit);
  if (found == kUnits.end()) throw std::runtime_error("no unit of time: " + unit);
  return found->second;
}

}  // namespace

base::Duration parse_span(const std::string& text) {
  double seconds = 0;
  std::size_t at = 0;
  while (at < text.size()) {
    std::size_t digits = 0;
    const double number = std::stod(text.substr(at), &digits);
    at += digits;
    const std::size_t begin = at;
    while (at < text.size() && std::isalpha(static_cast<unsigned char>(text[at])) != 0) ++at;
    seconds += number * seconds_of(text.substr(begin, at - begin));
    while (at < text.size() && text[at] == ' ') ++at;
  }
  return std::chrono::duration_cast<base::Duration>(std::chrono::duration<double>(seconds));
}

UnitFile UnitFile::load(const std::filesystem::path& file) {
  std::ifstream stream(file);
  if (!stream) throw std::runtime_error(file.string() + ": cannot be read");
  UnitFile unit;
  for (std::string line; std::getline(stream, line);) {
    const std::size_t equals = line.find('=');
    if (line.empty() || line[0] == '#' || line[0] == '[' || equals == std::string::npos) continue;
    const std::string value = trimmed(line.substr(equals + 1));
    std::vector<std::string>& values = unit.settings[trimmed(line.substr(0, equals))];
    if (value.empty()) values.clear();  // an empty value clears earlier ones
    if (!value.empty()) values.push_back(value);
  }
  return unit;
}

std::string UnitFile::value(const std::string& key, const std::string& fallback) const {
  const auto found = settings.find(key);
  return found == settings.end() || found->second.empty() ? fallback : found->second.back();
}

std::vector<std::string> UnitFile::all(const std::string& key) const {
  const auto found = settings.find(key);
  return found == settings.end() ? std::vector<std::string>{} : found->second;
}

base::Duration UnitFile::span(const std::string& key, const std::string& fallback) const {
  return parse_span(value(key, fallback));
}

}  // namespace cas::test
