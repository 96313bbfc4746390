// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "base/time/clock.hpp"

namespace CLI {
class App;
}

namespace cas::hils {

/// Reads the value of `--wait`: empty is not at all, "forever", or seconds.
/// @throws base::ConfigError
std::optional<base::Duration> parse_wait(const std::string& text);

/// A sentence for a command line that has a bare number behind `--wait`, which would be taken for
/// another argument; nullopt: it has none. Pure.
std::optional<std::string> misread_wait(std::span<const std::string_view> words);

/// Flags of a command that uses boards of the bench.
struct BoardFlags {
  std::string list;  ///< of `--boards`
  std::string wait;  ///< of `--wait`

  bool are_given() const { return !list.empty() || !wait.empty(); }
  /// boards.yaml; empty: there is none. @throws base::ConfigError
  std::filesystem::path file() const;
  /// How long to wait for boards that others hold; nullopt: not at all. @throws base::ConfigError
  std::optional<base::Duration> patience() const { return parse_wait(wait); }
};

/// Adds `--boards FILE`. @param list  of BoardFlags
void add_board_list(CLI::App& command, std::string& list);
/// Adds `--wait[=SECONDS]`. @param wait  of BoardFlags
void add_wait(CLI::App& command, std::string& wait);
/// Adds both.
void add_board_flags(CLI::App& command, BoardFlags& flags);

}  // namespace cas::hils
