// SPDX-License-Identifier: BSD-3-Clause
#include "base/time/clock.hpp"

namespace cas::base {

RunTime steady_now() {
  return RunTime(
      std::chrono::duration_cast<Duration>(std::chrono::steady_clock::now().time_since_epoch()));
}

}  // namespace cas::base
