// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "base/config/config.hpp"
#include "base/os/descriptor.hpp"
#include "base/os/pty.hpp"
#include "base/time/clock.hpp"

namespace cas::sim {

/// The unit's end of a serial line: a device, or a pseudo-terminal that it makes. Never blocks.
///
/// A write that the line takes in part is finished before anything else is sent, so that no packet
/// is torn. A device that is not there, or is unplugged, is tried again once a second.
class SerialWire {
 public:
  struct Counts {
    std::uint64_t write_errors = 0;
    std::uint64_t lost_lines = 0;  ///< times at which the device went
  };

  /// By key `pty` or key `device` of a plugin; with `unlocked_pty: true` the device may be a
  /// pseudo-terminal of a program that is none of CAS (socat). @throws base::ConfigError
  static std::unique_ptr<SerialWire> make(const base::ConfigNode& node, unsigned baud);
  /// Makes a pseudo-terminal under a symlink. @throws base::ConfigError
  static std::unique_ptr<SerialWire> make_pty(const base::ConfigNode& link);
  /// Opens a device, now or once it is there. @throws base::ConfigError when it is, and may not be
  /// used
  static std::unique_ptr<SerialWire> open_device(const base::ConfigNode& device, unsigned baud,
                                                 bool unlocked_pty = false);

  /// What has arrived; the view lives until the next call.
  std::span<const std::uint8_t> read(base::RunTime now);
  /// Whether it takes more: the rest of the last write has left.
  bool ready();
  /// Sends all, now or as the line takes it. Only when ready().
  void write(std::span<const std::uint8_t> bytes);
  /// Bytes that the driver holds unsent; 0 for a pseudo-terminal.
  std::size_t unsent() const;
  /// Bytes at the other end of a pseudo-terminal that its reader has not taken; 0 for a device.
  std::size_t unread() const;
  bool is_up() const { return descriptor() >= 0; }

  const Counts& counts() const { return counts_; }
  /// "serial /dev/ttyUSB0" or "pty run/ahrs".
  const std::string& endpoint() const { return endpoint_; }

 private:
  SerialWire() = default;
  int descriptor() const { return pty_ ? pty_->master() : device_.get(); }
  /// @return why not; empty: it is open
  std::string open();
  void lose(int error);
  void try_again(base::RunTime now);

  std::string endpoint_;
  std::string path_;  ///< of the device
  unsigned baud_ = 0;
  bool unlocked_pty_ = false;
  std::optional<base::Pty> pty_;
  base::Descriptor device_;
  std::optional<base::RunTime> look_again_;
  std::vector<std::uint8_t> rest_;
  std::array<std::uint8_t, 4096> buffer_{};
  Counts counts_;
};

}  // namespace cas::sim
