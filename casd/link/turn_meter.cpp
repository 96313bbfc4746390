// SPDX-License-Identifier: BSD-3-Clause
#include "casd/link/turn_meter.hpp"

#include <fcntl.h>
#include <sys/resource.h>
#include <time.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <string_view>

namespace cas::casd {
namespace {

// Controls at 400 Hz leave 2.5 ms to a turn. Sanitizers cost a factor of twenty; a virtual machine
// on shared processors counts time that it did not get as ours, up to four times as much. Links
// that begin open in one turn, each with calls for its lock, its device and its line in the log.
constexpr std::chrono::milliseconds kMostProcessor{200};
constexpr std::chrono::milliseconds kMostToOpen{5};
// At a turn a link reads one buffer of 64 KiB; and as much again for the figures of the thread.
constexpr std::uint64_t kMostBytesOfLink = std::uint64_t{64} << 10U;
// Whom a turn waits for holds a lock for a copy, and seldom: one of the 256 packets that a link
// takes at a turn. A call for each packet, or piece by piece through a file, waits more often.
constexpr std::uint64_t kMostWaits = 128;
constexpr std::uint64_t kMostWaitsToOpen = 8;

thread_local std::uint64_t wanted_waits = 0;

/// The number behind "rchar: ", the first line of /proc/thread-self/io.
std::uint64_t read_bytes(int fd) {
  constexpr std::string_view kKey = "rchar: ";
  std::array<char, 256> text{};
  const ssize_t size = ::pread(fd, text.data(), text.size(), 0);
  const std::string_view line(text.data(), size > 0 ? static_cast<std::size_t>(size) : 0);
  std::uint64_t bytes = 0;
  if (line.starts_with(kKey)) {
    std::from_chars(line.data() + kKey.size(), line.data() + line.size(), bytes);
  }
  return bytes;
}

}  // namespace

std::optional<std::string> excess(const TurnUse& use, std::size_t links) {
  if (use.processor > kMostProcessor + links * kMostToOpen) {
    return "took " + std::to_string(use.processor / std::chrono::milliseconds(1)) +
           " ms of the processor";
  }
  if (use.read_bytes > (links + 1) * kMostBytesOfLink)
    return "read " + std::to_string(use.read_bytes) + " bytes";
  if (use.waits > kMostWaits + links * kMostWaitsToOpen)
    return "waited " + std::to_string(use.waits) + " times";
  return std::nullopt;
}

void count_wanted_wait() { ++wanted_waits; }

TurnMeter::TurnMeter() : io_(::open("/proc/thread-self/io", O_RDONLY | O_CLOEXEC)) {}

void TurnMeter::begin() { begin_ = now(); }

TurnUse TurnMeter::end() const {
  const TurnUse end = now();
  return {.processor = end.processor - begin_.processor,
          .read_bytes = end.read_bytes - begin_.read_bytes,
          .waits = end.waits - std::min(begin_.waits, end.waits)};
}

TurnUse TurnMeter::now() const {
  timespec processor{};
  ::clock_gettime(CLOCK_THREAD_CPUTIME_ID, &processor);
  rusage usage{};
  ::getrusage(RUSAGE_THREAD, &usage);
  const auto waits = static_cast<std::uint64_t>(usage.ru_nvcsw);
  return {.processor =
              std::chrono::seconds(processor.tv_sec) + std::chrono::nanoseconds(processor.tv_nsec),
          .read_bytes = read_bytes(io_.get()),
          .waits = waits - std::min(waits, wanted_waits)};
}

}  // namespace cas::casd
