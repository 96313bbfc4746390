// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <poll.h>

#include <chrono>

#include "base/time/clock.hpp"

namespace cas::test {

/// Longest wait of a test for an event that must happen: far beyond any busy machine, never
/// reached.
inline constexpr base::Duration kPatience = std::chrono::seconds(20);

/// Looks every few milliseconds whether `condition` holds. @return false at the deadline
template <class Condition>
bool wait_until(Condition&& condition, base::Duration patience = kPatience) {
  const base::RunTime deadline = base::steady_now() + patience;
  while (!condition()) {
    if (base::steady_now() > deadline) return false;
    ::poll(nullptr, 0, 2);
  }
  return true;
}

}  // namespace cas::test
