// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

namespace router_load {

/// Starts the command after "--", or with --pump or --relay our own; without either there
/// is none, or --router-pid names it. @param slave  the PTY that our own opens
void start_router(const std::string& slave);
/// Waits until it has opened the PTY, and for --settle-ms besides.
void wait_for_router(const std::string& slave);
/// Ends the router that was started. @return what it used, as a member of a JSON object that
/// follows others; empty when none was started
std::string stop_router();

}  // namespace router_load
