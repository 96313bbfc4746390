// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <thread>
#include <vector>

#include "fcu/line/pty.hpp"

namespace cas::hils {

/// A cable between two programs that each open a serial port: two pseudo-terminals, and a thread
/// that carries the bytes from one to the other. Bytes that a port has no room for wait in the
/// cable; when a port is not read, further bytes are lost, as at the end of a real cable.
class PtyCable {
 public:
  /// Bytes that wait for one port at most: 0.7 s of 921 600 baud.
  static constexpr std::size_t kMaxWaiting = 64UL * 1024;

  /// @param first, second  symlinks to offer the two ends under. @throws base::ConfigError
  PtyCable(std::filesystem::path first, std::filesystem::path second);
  ~PtyCable();
  PtyCable(const PtyCable&) = delete;
  PtyCable& operator=(const PtyCable&) = delete;

  /// Bytes that were thrown away so far, of both directions. From any thread.
  std::uint64_t lost_bytes() const { return lost_; }

 private:
  /// One direction: reads at one port, keeps bytes the other has no room for, writes them later.
  class Wire {
   public:
    Wire(int from, int to) : from_(from), to_(to) {}
    bool waiting() const { return !bytes_.empty(); }
    /// @return bytes that found no place
    std::size_t take();
    void give();

   private:
    int from_;
    int to_;
    std::vector<char> bytes_;  // read, not yet written
  };

  void carry();

  fcu::Pty first_;
  fcu::Pty second_;
  std::atomic<bool> stopping_{false};
  std::atomic<std::uint64_t> lost_{0};
  std::thread thread_;
};

}  // namespace cas::hils
