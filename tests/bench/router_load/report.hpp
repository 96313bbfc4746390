// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "tests/bench/router_load/phase.hpp"

namespace router_load {

/// Appends formatted text.
void app(std::string& s, const char* fmt, ...) __attribute__((format(printf, 2, 3)));
/// A string as JSON holds it.
std::string esc(const std::string& s);
/// A phase as JSON; with `table` also for people, on standard error.
std::string report(const Phase& ph, const Out& r, bool table);

}  // namespace router_load
