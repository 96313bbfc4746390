// SPDX-License-Identifier: BSD-3-Clause
#include "base/time/clock.hpp"

#include <time.h>

#include <chrono>

namespace cas::base {

RunTime steady_now() {
  timespec now{};
  ::clock_gettime(CLOCK_MONOTONIC, &now);
  return RunTime(std::chrono::seconds(now.tv_sec) + std::chrono::nanoseconds(now.tv_nsec));
}

}  // namespace cas::base
