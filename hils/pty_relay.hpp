// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <atomic>
#include <filesystem>
#include <thread>

#include "fcu/pty.hpp"

namespace cas::hils {

/// A cable between two programs that each open a serial port: two pseudo-terminals, and a thread
/// that carries the bytes from one to the other. A port that nobody reads loses what is too much,
/// as a cable does.
class PtyRelay {
 public:
  /// @param first, second  symlinks to offer the two ends under. @throws base::ConfigError
  PtyRelay(std::filesystem::path first, std::filesystem::path second);
  ~PtyRelay();
  PtyRelay(const PtyRelay&) = delete;
  PtyRelay& operator=(const PtyRelay&) = delete;

 private:
  void carry();

  fcu::Pty first_;
  fcu::Pty second_;
  std::atomic<bool> stopping_{false};
  std::thread thread_;
};

}  // namespace cas::hils
