// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdio>
#include <exception>
#include <string_view>

#include "base/error.hpp"
#include "base/os/command_port.hpp"
#include "base/os/lack_of_memory.hpp"
#include "base/os/log.hpp"
#include "base/printable.hpp"

namespace cas::base {

/// Keeps a memory reserve, starts the log at `log_level` (a word of log::parse_level), runs a
/// program's body and turns an exception of either into one line on standard error, which may quote
/// a file and is printable all the same, and an exit code.
/// @return the result of `body`, kExitCommandPort, kExitConfig or kExitInternal
template <class Body>
int run_program(const char* name, std::string_view log_level, Body&& body) {
  try {
    keep_memory_reserve();
    log::init(name, log::parse_level(log_level));
    return body();
  } catch (const CommandPortError& error) {
    std::fprintf(stderr, "%s: %s\n", name, printable_lines(error.what()).c_str());
    return kExitCommandPort;
  } catch (const ConfigError& error) {
    std::fprintf(stderr, "%s: %s\n", name, printable_lines(error.what()).c_str());
    return kExitConfig;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s: internal error: %s\n", name, printable_lines(error.what()).c_str());
    return kExitInternal;
  }
}

}  // namespace cas::base
