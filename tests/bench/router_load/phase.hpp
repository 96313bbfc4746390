// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "tests/bench/router_load/process.hpp"
#include "tests/bench/router_load/wire.hpp"

namespace router_load {

/// What is sent in a phase; 0: nothing of it.
struct Phase {
  double down = 0, up = 0, gps = 0, seconds = 0;
  bool flood_down = false, flood_up = false;
};

/// What came of it.
struct Out {
  Res a, b;
  double wall = 0;
  long drops0 = -1, drops1 = -1;
  uint64_t sent[N_FLOW] = {};
  bool alive = true;
};

/// Warms up, sends, waits for the rest. The links then hold the phase's figures.
Out run_phase(const Phase& ph);

}  // namespace router_load
