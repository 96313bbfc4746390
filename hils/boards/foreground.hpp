// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "base/time/clock.hpp"

namespace cas::hils {

/// A command for the terminal.
struct ForegroundCommand {
  std::vector<std::string> arguments;      ///< a program without a slash is looked for in PATH
  std::vector<std::string> environment{};  ///< "NAME=VALUE", over this program's
  std::filesystem::path folder{};          ///< working folder; empty: this program's
  int kept = -1;                           ///< descriptor that it and its children inherit
};

/// Runs a command on this program's terminal, where it has one, in a process group of its own, and
/// waits for it: the terminal's keys are the command's; SIGTERM, SIGHUP, SIGINT and SIGQUIT to this
/// program go to the whole group. The command dies with this program.
/// @return its exit code; 128 + signal; 127 when it cannot be started
/// @throws base::ConfigError when no process can be made or its end cannot be seen
int run_in_foreground(const ForegroundCommand& command);

/// Becomes a process without a terminal, in the background. @return its number in the parent, 0 in
/// the child @throws base::ConfigError
int go_to_background();

/// Waits for SIGTERM, SIGINT or SIGHUP, or until the time is over.
void wait_to_be_ended(base::Duration most);

}  // namespace cas::hils
