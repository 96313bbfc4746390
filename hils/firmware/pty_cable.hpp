// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <thread>
#include <vector>

#include "base/os/descriptor.hpp"
#include "base/os/mutex.hpp"
#include "base/os/pty.hpp"
#include "base/time/clock.hpp"
#include "fcu/line/line_model.hpp"

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

  // From any thread; they take effect at once, not before they return.

  /// Pulls the plug at the first end: its port is gone, and bytes from the second are lost,
  /// uncounted, until it is plugged in again.
  void set_plugged(bool plugged);
  /// Sets the line model for both directions from now on. The cable takes the bytes of one read for
  /// one write of the model: mostly one packet of a program that writes packet by packet.
  void set_line(const fcu::LineConfig& line);

  /// Bytes that were thrown away so far, of both directions. From any thread.
  std::uint64_t lost_bytes() const { return lost_; }

 private:
  /// One direction: reads at one port, keeps bytes the other has no room for, writes them later.
  class Wire {
   public:
    Wire(const base::Pty& from, const base::Pty& to, std::uint64_t seed)
        : from_(from), to_(to), seed_(seed) {}
    bool waiting() const { return !bytes_.empty(); }
    void set_line(const fcu::LineConfig& line);
    /// @return bytes that found no place
    std::size_t take(base::RunTime now);
    /// Takes the bytes that the line model has ready. @return bytes lost for lack of room
    std::size_t arrive(base::RunTime now);
    void give();
    void cut();
    std::optional<base::RunTime> next_arrival() const {
      return line_ ? line_->next_arrival() : std::nullopt;
    }

   private:
    std::size_t keep(std::span<const std::uint8_t> bytes);

    const base::Pty& from_;
    const base::Pty& to_;
    std::uint64_t seed_;
    std::optional<fcu::LineModel> line_;  // nothing until set_line(): as they come
    std::vector<std::uint8_t> bytes_;     // not yet written
  };

  void carry(const std::stop_token& stop);
  void wait(Wire& there, Wire& back);
  void take_orders(Wire& there, Wire& back);
  void wake();

  base::Pty first_;
  base::Pty second_;
  base::Descriptor wake_;
  base::Mutex mutex_;
  bool plugged_ CAS_GUARDED_BY(mutex_) = true;
  std::optional<fcu::LineConfig> line_ CAS_GUARDED_BY(mutex_);  // not yet in force
  std::atomic<std::uint64_t> lost_{0};
  std::jthread thread_;
};

}  // namespace cas::hils
