// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "base/time/clock.hpp"

namespace cas::hils {

/// Runs a command on this program's terminal and waits for it: keys such as Ctrl-C are the
/// command's, SIGTERM and SIGHUP are passed on to it, and it dies with this program.
/// @param command  argv; a program without a slash is looked for in PATH
/// @param environment  "NAME=VALUE", over this program's
/// @return its exit code; 128 + signal; 127 when it cannot be started
int run_in_foreground(const std::vector<std::string>& command,
                      const std::vector<std::string>& environment);

/// Becomes a process without a terminal, in the background. @return its number in the parent, 0 in
/// the child @throws base::ConfigError
int go_to_background();

/// Waits until this process is told to end (SIGTERM, SIGINT, SIGHUP), or until the time is over.
void wait_to_be_ended(base::Duration most);

}  // namespace cas::hils
