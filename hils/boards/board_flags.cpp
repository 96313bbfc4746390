// SPDX-License-Identifier: BSD-3-Clause
#include "hils/boards/board_flags.hpp"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <charconv>
#include <system_error>

#include "base/error.hpp"
#include "hils/boards/board_list.hpp"

namespace cas::hils {

namespace {

constexpr const char* kForever = "forever";
constexpr double kForever_s = 3e9;

}  // namespace

std::optional<base::Duration> parse_wait(const std::string& text) {
  if (text.empty()) return std::nullopt;
  if (text == kForever) return base::from_seconds(kForever_s);
  double seconds = 0;
  const char* const end = text.data() + text.size();
  const auto result = std::from_chars(text.data(), end, seconds);
  if (result.ec != std::errc() || result.ptr != end || !(seconds >= 0 && seconds <= kForever_s)) {
    throw base::ConfigError("--wait=" + text + ": is no number of seconds");
  }
  return base::from_seconds(seconds);
}

std::optional<std::string> misread_wait(std::span<const std::string_view> words) {
  for (std::size_t i = 0; i + 1 < words.size() && words[i] != "--"; ++i) {
    const std::string_view next = words[i + 1];
    if (words[i] != "--wait" || next.empty()) continue;
    if (next.find_first_not_of("0123456789.") != std::string_view::npos) continue;
    return fmt::format("--wait has its seconds behind a '=': --wait={}", next);
  }
  return std::nullopt;
}

std::filesystem::path BoardFlags::file() const { return find_board_list(list); }

void add_board_list(CLI::App& command, std::string& list) {
  command.add_option("--boards", list,
                     "The list of boards (CAS_BOARDS, ~/.config/cas/boards.yaml, "
                     "/etc/cas/boards.yaml)");
}

void add_wait(CLI::App& command, std::string& wait) {
  command.add_flag(std::string("--wait{") + kForever + "}", wait,
                   "Stand in the queue for a board that somebody else holds; --wait=SECONDS: no "
                   "longer than that");
}

void add_board_flags(CLI::App& command, BoardFlags& flags) {
  add_board_list(command, flags.list);
  add_wait(command, flags.wait);
}

}  // namespace cas::hils
