// SPDX-License-Identifier: BSD-3-Clause
#include "base/config/config_origin.hpp"

#include <algorithm>
#include <charconv>
#include <system_error>
#include <utility>

#include "base/config/config.hpp"

namespace cas::base {
namespace {

constexpr std::string_view kMark = "#: ";
constexpr std::string_view kArrow = " <- ";
constexpr std::string_view kColon = ": ";
constexpr std::size_t kMostNotes = 100'000;

/// "FILE:LINE: key.path"; a place without a file where the text is none.
ConfigOrigin parse_place(std::string_view text) {
  const std::size_t path = text.rfind(kColon);
  if (path == std::string_view::npos) return {};
  const std::size_t line = text.rfind(':', path - 1);
  if (path == 0 || line == std::string_view::npos) return {};
  ConfigOrigin origin;
  const std::string_view digits = text.substr(line + 1, path - line - 1);
  const auto read = std::from_chars(digits.data(), digits.data() + digits.size(), origin.line);
  if (read.ec != std::errc() || read.ptr != digits.data() + digits.size()) return {};
  origin.file = text.substr(0, line);
  origin.path = text.substr(path + kColon.size());
  return origin;
}

/// A note is one line.
bool fits_a_line(std::string_view text) { return text.find('\n') == std::string_view::npos; }

void add_note(const std::string& path, const ConfigNode& from, std::string& notes) {
  const ConfigOrigin origin{.file = from.file().string(), .line = from.line(), .path = from.path()};
  const std::string place = origin.text();
  const bool has_place = !origin.file.empty() && origin.line > 0;
  if (!path.empty() && has_place && fits_a_line(path) && fits_a_line(place)) {
    notes += std::string(kMark) + path + std::string(kArrow) + place + "\n";
  }
  if (from.is_map()) {
    for (const auto& [key, child] : from.entries()) {
      add_note(path.empty() ? key : path + "." + key, child, notes);
    }
  } else if (from.is_list()) {
    std::size_t index = 0;
    for (const ConfigNode& item : from.items()) {
      add_note(path + "[" + std::to_string(index++) + "]", item, notes);
    }
  }
}

/// The path without its last key or index; empty at the root.
std::string_view parent_of(std::string_view path) {
  const std::size_t cut = path.find_last_of(".[");
  return cut == std::string_view::npos ? std::string_view() : path.substr(0, cut);
}

}  // namespace

std::string origin_notes(std::string_view path, const ConfigNode& from) {
  std::string notes;
  add_note(std::string(path), from, notes);
  return notes;
}

std::string ConfigOrigin::text() const {
  return file + ":" + std::to_string(line) + std::string(kColon) + path;
}

ConfigOrigins ConfigOrigins::read(std::string_view text) {
  ConfigOrigins origins;
  while (!text.empty() && origins.by_path_.size() < kMostNotes) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    const std::string_view line = text.substr(0, end);
    text.remove_prefix(std::min(end + 1, text.size()));
    const std::size_t arrow = line.find(kArrow);
    const bool is_note = line.starts_with(kMark) && arrow != std::string_view::npos;
    if (!is_note || arrow < kMark.size()) continue;
    ConfigOrigin origin = parse_place(line.substr(arrow + kArrow.size()));
    if (origin.file.empty()) continue;
    const std::string_view path = line.substr(kMark.size(), arrow - kMark.size());
    origins.by_path_.insert_or_assign(std::string(path), std::move(origin));
  }
  return origins;
}

ConfigOrigin ConfigOrigins::of(std::string_view path) const {
  for (std::string_view above = path; !above.empty(); above = parent_of(above)) {
    const auto found = by_path_.find(above);
    if (found == by_path_.end()) continue;
    ConfigOrigin origin = found->second;
    std::string_view below = path.substr(above.size());
    if (origin.path.empty() && below.starts_with('.')) below.remove_prefix(1);
    origin.path += below;
    return origin;
  }
  return {};
}

}  // namespace cas::base
