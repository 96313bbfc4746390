// SPDX-License-Identifier: BSD-3-Clause
#include "fcu/params/param_file.hpp"

#include <cstdint>
#include <optional>
#include <sstream>
#include <system_error>

#include "base/error.hpp"
#include "base/os/write_file.hpp"
#include "base/read_file.hpp"

namespace cas::fcu {
namespace {

constexpr std::size_t kMostBytes = std::size_t{1} << 20U;
constexpr std::string_view kEnd = "# end ";

/// FNV-1a over the text, so that a cut or changed file shows.
std::uint64_t checksum(std::string_view text) {
  std::uint64_t hash = 14695981039346656037ULL;
  for (const char c : text) hash = (hash ^ static_cast<std::uint8_t>(c)) * 1099511628211ULL;
  return hash;
}

std::string with_end(const std::string& lines) {
  std::ostringstream out;
  out << lines << kEnd << std::hex << checksum(lines) << '\n';
  return out.str();
}

std::optional<std::vector<ParamFile::Entry>> read_whole(const std::filesystem::path& file) {
  std::string text;
  try {
    text = base::read_foreign_file(file, "parameter file", kMostBytes);
  } catch (const base::ConfigError&) {
    return std::nullopt;
  }
  const std::size_t end = text.rfind(kEnd);
  if (end == std::string::npos || with_end(text.substr(0, end)) != text) return std::nullopt;
  return ParamFile::parse(text.substr(0, end));
}

}  // namespace

std::vector<ParamFile::Entry> ParamFile::parse(const std::string& lines) {
  std::istringstream in(lines);
  std::vector<Entry> entries;
  for (Entry entry; in >> entry.name >> entry.value;) entries.push_back(entry);
  return entries;
}

std::vector<ParamFile::Entry> ParamFile::load() const {
  const std::filesystem::path backup = file_.string() + ".bak";
  if (auto entries = read_whole(file_)) return *entries;
  if (auto entries = read_whole(backup)) return *entries;
  std::error_code error;
  if (std::filesystem::exists(file_, error)) {
    throw base::ConfigError(file_.string() + " is damaged and has no intact backup");
  }
  return {};
}

bool ParamFile::save(const std::string& lines) const {
  std::error_code error;
  if (read_whole(file_)) {
    std::filesystem::copy_file(file_, file_.string() + ".bak",
                               std::filesystem::copy_options::overwrite_existing, error);
  }
  try {
    base::write_file(file_, with_end(lines));
  } catch (const base::ConfigError&) {
    return false;
  }
  return true;
}

}  // namespace cas::fcu
