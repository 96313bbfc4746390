// SPDX-License-Identifier: BSD-3-Clause
#include "casd/link/wake_signal.hpp"

#include <sys/eventfd.h>

#include <cstdint>

#include "base/error.hpp"

namespace cas::casd {

WakeSignal::WakeSignal() : event_(::eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK)) {
  if (!event_) throw base::ConfigError("no event descriptor: too many open files");
}

void WakeSignal::raise() {
  if (raised_.exchange(true, std::memory_order_acq_rel)) return;
  const std::uint64_t one = 1;
  [[maybe_unused]] const auto written = ::write(event_.get(), &one, sizeof one);
}

void WakeSignal::lower() {
  std::uint64_t count = 0;
  [[maybe_unused]] const auto taken = ::read(event_.get(), &count, sizeof count);
  raised_.exchange(false, std::memory_order_acq_rel);
}

}  // namespace cas::casd
