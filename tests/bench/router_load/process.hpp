// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <sys/types.h>

#include <cstdint>
#include <string>

namespace router_load {

/// What a process has used so far.
struct Res {
  double user = 0, sys = 0, run_ns = 0;
  uint64_t vcs = 0, ics = 0;
  long rss_kb = 0, hwm_kb = 0;
  int threads = 0;
  bool ok = false;
};
Res sample(pid_t pid);
/// Kernel receive-buffer drops of the router's UDP port.
long udp_drops(int port);
bool has_slave_open(pid_t pid, const std::string& slave);
bool alive(pid_t pid);

}  // namespace router_load
