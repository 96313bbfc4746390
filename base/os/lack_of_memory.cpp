// SPDX-License-Identifier: BSD-3-Clause
#include "base/os/lack_of_memory.hpp"

#include <unistd.h>

#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <exception>
#include <string>

#include "base/os/log.hpp"

namespace cas::base {
namespace {

/// Memory for the steps between a refused allocation and the line of the log that reports it.
constexpr std::size_t kReserveBytes = std::size_t{256} << 10U;
/// A refusal so soon after the reserve went asks for more than there is.
constexpr std::chrono::nanoseconds kBetweenReserves = std::chrono::milliseconds(100);
constexpr std::chrono::nanoseconds kBetweenLines = std::chrono::seconds(1);

std::atomic<void*> reserve{nullptr};
std::atomic<std::int64_t> reserve_left_ns{0};
std::atomic<std::int64_t> next_line_ns{0};
std::atomic<std::uint64_t> refusals{0};

std::int64_t now_ns() {
  return std::chrono::nanoseconds(std::chrono::steady_clock::now().time_since_epoch()).count();
}

/// What `new` calls when it gets no memory; it tries again unless this throws.
void give_reserve() {
  refusals.fetch_add(1, std::memory_order_relaxed);
  void* block = reserve.exchange(nullptr);
  const std::int64_t now = now_ns();
  if (block == nullptr && now - reserve_left_ns.load() > kBetweenReserves.count()) {
    block = std::malloc(kReserveBytes);
  }
  if (block == nullptr) throw std::bad_alloc();
  reserve_left_ns.store(now);
  std::free(block);
}

}  // namespace

void keep_memory_reserve() {
  void* const block = std::malloc(kReserveBytes);
  std::free(reserve.exchange(block));
  std::set_new_handler(give_reserve);
}

std::uint64_t memory_refusals() { return refusals.load(std::memory_order_relaxed); }

void note_lack_of_memory(std::string_view who) noexcept {
  const std::int64_t now = now_ns();
  std::int64_t due = next_line_ns.load();
  if (now < due || !next_line_ns.compare_exchange_strong(due, now + kBetweenLines.count())) return;
  try {
    log::error(std::string(who) + ": no memory; what it was about to do is lost, and it goes on");
  } catch (const std::exception&) {
    constexpr std::string_view kLine = "no memory; what was about to be done is lost\n";
    [[maybe_unused]] const auto written = ::write(STDERR_FILENO, kLine.data(), kLine.size());
  }
}

}  // namespace cas::base
