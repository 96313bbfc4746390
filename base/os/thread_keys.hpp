// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <sched.h>

#include <string>
#include <tuple>
#include <vector>

#include "base/config/config_keys.hpp"
#include "base/os/thread.hpp"
#include "base/text.hpp"

namespace cas::base {

struct CpuNumbers {
  static void read(const ConfigNode& node, std::vector<int>& cpus) {
    for (const ConfigNode& item : node.items()) {
      cpus.push_back(item.as<int>());
      if (cpus.back() < 0 || cpus.back() >= CPU_SETSIZE) item.fail("is no CPU number");
    }
  }
  static std::string text(const std::vector<int>& cpus) {
    return cpus.empty()
               ? "any"
               : "[" + joined(cpus, ", ", [](int cpu) { return std::to_string(cpu); }) + "]";
  }
  static std::string values() { return "list of numbers"; }
  static std::array<std::string, 2> samples() { return {"[0]", "[1]"}; }
};

/// Keys of ThreadOptions.
inline constexpr std::tuple kThreadKeys{
    key<&ThreadOptions::fifo_priority>("fifo_priority", Whole{1, 99},
                                       "real-time priority (SCHED_FIFO)"),
    key<&ThreadOptions::cpus>("cpus", CpuNumbers{}, "processors that the thread may run on"),
};

}  // namespace cas::base
