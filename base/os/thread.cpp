// SPDX-License-Identifier: BSD-3-Clause
#include "base/os/thread.hpp"

#include <pthread.h>
#include <sched.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/resource.h>

#include <atomic>
#include <cerrno>
#include <system_error>

#include "base/os/log.hpp"
#include "base/os/thread_keys.hpp"

namespace cas::base {
namespace {

constexpr std::size_t kMaxThreadName = 15;  // pthread_setname_np, without the NUL

/// Warns the first time only: eight threads without a right are one message, not eight.
void warn_once(std::atomic<bool>& warned, const std::string& what, int error) {
  if (warned.exchange(true)) return;
  log::warn(what + ": " + std::generic_category().message(error));
}

void set_fifo_priority(const std::string& name, int priority) {
  static std::atomic<bool> warned{false};
  sched_param parameters{};
  parameters.sched_priority = priority;
  const int error = ::pthread_setschedparam(::pthread_self(), SCHED_FIFO, &parameters);
  if (error != 0) warn_once(warned, "thread " + name + " runs without SCHED_FIFO", error);
}

void set_affinity(const std::string& name, const std::vector<int>& cpus) {
  static std::atomic<bool> warned{false};
  cpu_set_t set;
  CPU_ZERO(&set);
  for (const int cpu : cpus) CPU_SET(static_cast<std::size_t>(cpu), &set);
  const int error = ::pthread_setaffinity_np(::pthread_self(), sizeof set, &set);
  if (error != 0) warn_once(warned, "thread " + name + " is not bound to its CPUs", error);
}

}  // namespace

ThreadOptions parse_thread_options(const ConfigNode& node) {
  ThreadOptions options;
  read_keys(node, kThreadKeys, options);
  return options;
}

void configure_this_thread(const std::string& name, const ThreadOptions& options) {
  ::pthread_setname_np(::pthread_self(), name.substr(0, kMaxThreadName).c_str());
  if (options.fifo_priority) set_fifo_priority(name, *options.fifo_priority);
  if (!options.cpus.empty()) set_affinity(name, options.cpus);
}

bool lower_this_thread(const std::string& name) {
  ::pthread_setname_np(::pthread_self(), name.substr(0, kMaxThreadName).c_str());
  const sched_param none{};
  constexpr int kNice = 10;
  // 0: this thread, not its process
  return ::sched_setscheduler(0, SCHED_BATCH, &none) == 0 &&
         ::setpriority(PRIO_PROCESS, 0, kNice) == 0;
}

bool lock_memory() {
  ::prctl(PR_SET_TIMERSLACK, 1UL, 0UL, 0UL, 0UL);
  if (::mlockall(MCL_CURRENT | MCL_FUTURE) == 0) return true;
  log::warn("memory is not locked: " + std::generic_category().message(errno));
  return false;
}

}  // namespace cas::base
