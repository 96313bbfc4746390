// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "base/cli/command_tree.hpp"
#include "base/time/clock.hpp"

namespace cas::hils {

/// Reads the value of `--wait`: empty is not at all, "forever", or seconds.
/// @throws base::ConfigError
std::optional<base::Duration> parse_wait(const std::string& text);
/// Adds `--wait[=SECONDS]` to a command. @param text  of parse_wait()
void add_wait(CLI::App& command, std::string& text);

/// A sentence for a command line that has a bare number behind `--wait`, which would be taken for
/// another argument; nothing: it has none. Pure.
std::optional<std::string> misread_wait(std::span<const std::string_view> words);

/// What a shell offers as arguments of the verbs.
base::cli::WordsByCommand board_words();

/// The verbs of `hils board`.
class BoardCommand {
 public:
  /// Adds them to the program's command line.
  explicit BoardCommand(CLI::App& app);
  ~BoardCommand();
  BoardCommand(const BoardCommand&) = delete;
  BoardCommand& operator=(const BoardCommand&) = delete;

  bool parsed() const;
  /// Does what the command line says. @return exit code
  /// @throws BoardError, RunStopped, base::ConfigError, std::runtime_error
  int run() const;

 private:
  struct Flags;
  std::unique_ptr<Flags> flags_;
};

}  // namespace cas::hils
