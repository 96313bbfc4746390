// SPDX-License-Identifier: BSD-3-Clause
#include "casd/link/turn_meter.hpp"

#include <fcntl.h>
#include <sys/resource.h>
#include <time.h>
#include <unistd.h>

#include <array>
#include <charconv>
#include <string_view>

namespace cas::casd {
namespace {

// A turn takes well under a millisecond; sanitizers cost a factor of twenty.
constexpr std::chrono::milliseconds kMostProcessor{500};
// Links read at most 64 KiB each at a turn.
constexpr std::uint64_t kMostBytes = std::uint64_t{16} << 20U;
// `threads: blocking` waits for its line with each packet, hundreds of packets at a turn.
constexpr std::uint64_t kMostWaits = 10'000;

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

std::optional<std::string> excess(const TurnUse& use) {
  if (use.processor > kMostProcessor) {
    return "took " + std::to_string(use.processor / std::chrono::milliseconds(1)) +
           " ms of the processor";
  }
  if (use.read_bytes > kMostBytes) return "read " + std::to_string(use.read_bytes) + " bytes";
  if (use.waits > kMostWaits) return "waited " + std::to_string(use.waits) + " times";
  return std::nullopt;
}

TurnMeter::TurnMeter() : io_(::open("/proc/thread-self/io", O_RDONLY | O_CLOEXEC)) {}

void TurnMeter::begin() { begin_ = now(); }

TurnUse TurnMeter::end() const {
  const TurnUse end = now();
  return {.processor = end.processor - begin_.processor,
          .read_bytes = end.read_bytes - begin_.read_bytes,
          .waits = end.waits - begin_.waits};
}

TurnUse TurnMeter::now() const {
  timespec processor{};
  ::clock_gettime(CLOCK_THREAD_CPUTIME_ID, &processor);
  rusage usage{};
  ::getrusage(RUSAGE_THREAD, &usage);
  return {.processor =
              std::chrono::seconds(processor.tv_sec) + std::chrono::nanoseconds(processor.tv_nsec),
          .read_bytes = read_bytes(io_.get()),
          .waits = static_cast<std::uint64_t>(usage.ru_nvcsw)};
}

}  // namespace cas::casd
