// SPDX-License-Identifier: BSD-3-Clause
#include "base/os/thread.hpp"

#include <fcntl.h>
#include <pthread.h>
#include <sched.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <charconv>
#include <system_error>

#include "base/error.hpp"
#include "base/os/log.hpp"
#include "base/os/thread_keys.hpp"

namespace cas::base {
namespace {

constexpr std::size_t kMaxThreadName = 15;  // pthread_setname_np, without the NUL

/// Warns the first time only: eight threads without a right are one message, not eight.
void warn_once(std::atomic<bool>& warned, const std::string& what, int error) {
  if (warned.exchange(true)) return;
  log::warn(what + ": " + error_text(error));
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
  const int error = bind_to_cpus(cpus);
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

ThreadTimesReader::ThreadTimesReader()
    : file_(::open("/proc/thread-self/schedstat", O_RDONLY | O_CLOEXEC)) {}

std::optional<ThreadTimes> ThreadTimesReader::read() const {
  // Time on a processor and time in a queue, both in nanoseconds, and turns
  // (Documentation/scheduler/sched-stats).
  std::array<char, 80> text{};
  const ssize_t size = ::pread(file_.get(), text.data(), text.size(), 0);
  if (size <= 0) return std::nullopt;
  const char* at = text.data();
  const char* const end = at + size;
  std::array<std::uint64_t, 3> values{};
  for (std::uint64_t& value : values) {
    at = std::find_if(at, end, [](char c) { return c != ' '; });
    const auto [next, error] = std::from_chars(at, end, value);
    if (error != std::errc{}) return std::nullopt;
    at = next;
  }
  const auto [ran, queued, turns] = values;
  if (turns == 0) return std::nullopt;
  return ThreadTimes{.turns = turns,
                     .ran = std::chrono::nanoseconds(static_cast<std::int64_t>(ran)),
                     .queued = std::chrono::nanoseconds(static_cast<std::int64_t>(queued))};
}

std::vector<int> allowed_cpus() {
  cpu_set_t set;
  CPU_ZERO(&set);
  std::vector<int> cpus;
  if (::pthread_getaffinity_np(::pthread_self(), sizeof set, &set) != 0) return cpus;
  for (int cpu = 0; cpu < CPU_SETSIZE; ++cpu) {
    if (CPU_ISSET(static_cast<std::size_t>(cpu), &set)) cpus.push_back(cpu);
  }
  return cpus;
}

int bind_to_cpus(const std::vector<int>& cpus) {
  cpu_set_t set;
  CPU_ZERO(&set);
  for (const int cpu : cpus) CPU_SET(static_cast<std::size_t>(cpu), &set);
  return ::pthread_setaffinity_np(::pthread_self(), sizeof set, &set);
}

bool lock_memory() {
  ::prctl(PR_SET_TIMERSLACK, 1UL, 0UL, 0UL, 0UL);
  if (::mlockall(MCL_CURRENT | MCL_FUTURE) == 0) return true;
  log::warn("memory is not locked: " + error_text(errno));
  return false;
}

}  // namespace cas::base
