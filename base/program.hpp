// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdio>
#include <exception>

#include "base/error.hpp"

namespace cas::base {

/// Runs a program's body and turns what it throws into one line on standard error and an exit code.
template <class Body>
int run_program(const char* name, Body&& body) {
  try {
    return body();
  } catch (const ConfigError& error) {
    std::fprintf(stderr, "%s: %s\n", name, error.what());
    return kExitConfig;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s: internal error: %s\n", name, error.what());
    return kExitInternal;
  }
}

}  // namespace cas::base
