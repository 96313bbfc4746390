// SPDX-License-Identifier: BSD-3-Clause
#include "casd/link/turn_meter.hpp"

#include <fcntl.h>
#include <sys/resource.h>
#include <time.h>
#include <unistd.h>

#include <fmt/format.h>
#include <algorithm>
#include <array>
#include <charconv>
#include <string_view>

namespace cas::casd {
namespace {

// Controls at 400 Hz leave 2.5 ms for a turn. Sanitizers cost a factor of twenty. A virtual machine
// on shared processors charges time to the thread that it did not get, a factor of up to four. All
// links open in the first turn, each with calls for its lock, its device and its line in the log.
constexpr std::chrono::milliseconds kMostProcessor{200};
constexpr std::chrono::milliseconds kMostToOpen{5};
// In a turn each link reads one buffer of 64 KiB, and the thread as much again for its figures.
constexpr std::uint64_t kMostBytesOfLink = std::uint64_t{64} << 10U;
// Locks are held for a copy, so a turn seldom waits for one: far less than once for each of the 256
// packets that a link takes in a turn. A blocking call for each packet, or a file that is read in
// pieces, waits more often.
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
    return fmt::format("took {} ms of the processor", use.processor / std::chrono::milliseconds(1));
  }
  if (use.read_bytes > (links + 1) * kMostBytesOfLink)
    return fmt::format("read {} bytes", use.read_bytes);
  if (use.waits > kMostWaits + links * kMostWaitsToOpen)
    return fmt::format("waited {} times", use.waits);
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
