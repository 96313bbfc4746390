// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <atomic>

#include "base/os/descriptor.hpp"

namespace cas::casd {

/// Wakes a thread that waits in poll. Many calls before it looks cost one system call.
class WakeSignal {
 public:
  WakeSignal();
  /// From any thread.
  void raise();
  /// By the thread that was woken, before it looks at what there is to do.
  void lower();
  int descriptor() const { return event_.get(); }

 private:
  base::Descriptor event_;
  std::atomic<bool> raised_{false};
};

}  // namespace cas::casd
