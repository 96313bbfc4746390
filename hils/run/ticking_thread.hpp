// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <thread>

#include "base/os/descriptor.hpp"
#include "base/time/clock.hpp"

namespace cas::hils {

/// A thread that works whenever a descriptor can be read, and at least once in each period. It ends
/// with the object: declare it after all members that its work uses.
class TickingThread {
 public:
  /// @throws base::ConfigError when the system has no descriptor left
  TickingThread(int fd, base::Duration period, std::function<void()> work);

 private:
  base::Descriptor wake_;
  std::jthread thread_;
};

}  // namespace cas::hils
