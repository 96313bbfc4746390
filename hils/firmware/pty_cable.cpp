// SPDX-License-Identifier: BSD-3-Clause
#include "hils/firmware/pty_cable.hpp"

#include <poll.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <span>
#include <utility>

#include "base/error.hpp"
#include "base/os/lack_of_memory.hpp"
#include "base/os/log.hpp"

namespace cas::hils {
namespace {

constexpr base::Duration kLookForTheEnd = std::chrono::milliseconds(100);
// Seeds of the line models, one for each direction.
constexpr std::uint64_t kSeedThere = 1;
constexpr std::uint64_t kSeedBack = 2;

short events(bool writes) { return static_cast<short>(writes ? POLLIN | POLLOUT : POLLIN); }

timespec until(std::optional<base::RunTime> arrival) {
  base::Duration left = kLookForTheEnd;
  if (arrival) left = std::clamp(*arrival - base::steady_now(), base::Duration::zero(), left);
  const auto seconds = std::chrono::floor<std::chrono::seconds>(left);
  return {.tv_sec = seconds.count(), .tv_nsec = (left - seconds).count()};
}

}  // namespace

PtyCable::PtyCable(std::filesystem::path first, std::filesystem::path second)
    : first_(std::move(first)),
      second_(std::move(second)),
      wake_(::eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK)) {
  if (!wake_) throw base::ConfigError("cannot open an eventfd");
  thread_ = std::jthread([this](const std::stop_token& stop) { carry(stop); });
}

PtyCable::~PtyCable() {
  thread_.request_stop();
  wake();
}

void PtyCable::set_plugged(bool plugged) {
  {
    const base::MutexLock lock(mutex_);
    plugged_ = plugged;
  }
  wake();
}

void PtyCable::set_line(const fcu::LineConfig& line) {
  {
    const base::MutexLock lock(mutex_);
    line_ = line;
  }
  wake();
}

void PtyCable::wake() { ::eventfd_write(wake_.get(), 1); }

void PtyCable::carry(const std::stop_token& stop) {
  Wire there(first_, second_, kSeedThere);
  Wire back(second_, first_, kSeedBack);
  while (!stop.stop_requested()) {
    base::outlive_lack_of_memory("serial line", [&] {
      take_orders(there, back);
      wait(there, back);
    });
  }
}

/// Only this thread touches the terminals.
void PtyCable::take_orders(Wire& there, Wire& back) {
  const base::MutexLock lock(mutex_);
  if (line_) {
    there.set_line(*line_);
    back.set_line(*line_);
    line_.reset();
  }
  const bool plugged = first_.master() >= 0;
  if (plugged == plugged_) return;
  there.cut();
  back.cut();
  if (plugged) return first_.hang_up();
  try {
    first_.open();
  } catch (const base::ConfigError& error) {
    plugged_ = false;
    base::log::error(std::string("the serial line stays unplugged: ") + error.what());
  }
}

/// Waits for bytes, and carries them.
void PtyCable::wait(Wire& there, Wire& back) {
  std::array<pollfd, 3> ends{pollfd{first_.master(), events(back.waiting()), 0},
                             pollfd{second_.master(), events(there.waiting()), 0},
                             pollfd{wake_.get(), POLLIN, 0}};
  std::optional<base::RunTime> next = there.next_arrival();
  if (const auto other = back.next_arrival(); other && (!next || *other < *next)) next = other;
  const timespec patience = until(next);
  if (::ppoll(ends.data(), ends.size(), &patience, nullptr) < 0) return;
  if (eventfd_t count = 0; (ends[2].revents & POLLIN) != 0) ::eventfd_read(wake_.get(), &count);
  if ((ends[0].revents & POLLOUT) != 0) back.give();
  if ((ends[1].revents & POLLOUT) != 0) there.give();
  const base::RunTime now = base::steady_now();
  if ((ends[0].revents & POLLIN) != 0) lost_ += there.take(now);
  if ((ends[1].revents & POLLIN) != 0) lost_ += back.take(now);
  lost_ += there.arrive(now) + back.arrive(now);
}

void PtyCable::Wire::set_line(const fcu::LineConfig& line) {
  if (!line_) line_.emplace(line, seed_);
  line_->configure(line);
}

std::size_t PtyCable::Wire::take(base::RunTime now) {
  std::array<std::uint8_t, 4096> chunk;
  const ssize_t size = ::read(from_.master(), chunk.data(), chunk.size());
  if (size <= 0 || to_.master() < 0) return 0;
  const auto read = std::span(chunk).first(static_cast<std::size_t>(size));
  if (!line_) return keep(read);
  return read.size() - line_->write(read, now);
}

std::size_t PtyCable::Wire::arrive(base::RunTime now) {
  if (!line_) return 0;
  std::array<std::uint8_t, 4096> chunk;
  std::size_t lost = 0;
  while (const std::size_t size = line_->read(chunk, now))
    lost += keep(std::span(chunk).first(size));
  return lost;
}

std::size_t PtyCable::Wire::keep(std::span<const std::uint8_t> bytes) {
  const std::size_t kept = std::min(bytes.size(), kMaxWaiting - bytes_.size());
  const bool was_waiting = waiting();
  bytes_.insert(bytes_.end(), bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(kept));
  if (!was_waiting) give();
  return bytes.size() - kept;
}

void PtyCable::Wire::give() {
  const ssize_t size = ::write(to_.master(), bytes_.data(), bytes_.size());
  if (size > 0) bytes_.erase(bytes_.begin(), bytes_.begin() + size);
}

/// Bytes on their way are lost.
void PtyCable::Wire::cut() {
  bytes_.clear();
  if (!line_) return;
  line_->hang_up();
  line_->restore();
}

}  // namespace cas::hils
