// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "base/config/config.hpp"
#include "base/export.hpp"
#include "base/os/descriptor.hpp"

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

/// The scheduler's counters of a thread.
struct ThreadTimes {
  std::uint64_t turns = 0;  ///< how often it began to run on a processor
  std::chrono::nanoseconds ran{};
  std::chrono::nanoseconds queued{};  ///< ready to run, but others ran
};

/// Reads the times of the thread that made it (/proc/thread-self/schedstat).
class CAS_BASE_EXPORT ThreadTimesReader {
 public:
  ThreadTimesReader();
  /// nullopt: this kernel does not count them.
  std::optional<ThreadTimes> read() const;

 private:
  Descriptor file_;
};

/// The processors that the calling thread may run on, in rising order.
CAS_BASE_EXPORT std::vector<int> allowed_cpus();
/// Binds the calling thread to processors. @return 0, or errno
CAS_BASE_EXPORT int bind_to_cpus(const std::vector<int>& cpus);

/// mlockall(current and future) and 1 ns timer slack. @return false with a warning when refused
CAS_BASE_EXPORT bool lock_memory();

}  // namespace cas::base
