// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "base/config/config.hpp"
#include "base/export.hpp"

namespace cas::base {

/// Scheduling wishes of a thread. Missing rights give one warning, never an error.
struct ThreadOptions {
  std::optional<int> fifo_priority;  ///< SCHED_FIFO 1..99
  std::vector<int> cpus;             ///< affinity; empty: any

  friend bool operator==(const ThreadOptions&, const ThreadOptions&) = default;
};

/// Reads {fifo_priority, cpus}. @throws ConfigError
CAS_BASE_EXPORT ThreadOptions parse_thread_options(const ConfigNode& node);
/// Names the calling thread (15 characters) and applies the options to it.
CAS_BASE_EXPORT void configure_this_thread(const std::string& name, const ThreadOptions& options);
/// Names the calling thread and puts it behind others (SCHED_BATCH, nice 10), whatever scheduling
/// it has inherited. It still runs: it may hold a lock of the allocator that others wait for.
/// @return false when the system refuses
CAS_BASE_EXPORT bool lower_this_thread(const std::string& name);
/// mlockall(current and future) and 1 ns timer slack. @return false with a warning when refused
CAS_BASE_EXPORT bool lock_memory();

}  // namespace cas::base
