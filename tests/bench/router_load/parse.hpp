// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "tests/bench/router_load/state.hpp"

namespace router_load {

/// Parses what it can, returns the number of bytes consumed. g_mu is held.
/// @param whole  a datagram: what is left over is garbage
size_t parse(Link& l, size_t li, const uint8_t* p, size_t n, int64_t t, bool whole);

}  // namespace router_load
